/* What the verbs of the command share. Public headers only. */
#ifndef HPR_CLI_CLI_H
#define HPR_CLI_CLI_H

#include <hprad/job.h>
#include <popt.h>
#include <signal.h>
#include <stdbool.h>
#include <time.h>

enum {
    CLI_GO_ON = -1, /* not an exit code: the arguments are fine */
    CLI_DONE = 0,
    CLI_FAILED = 1,
    CLI_USAGE = 2,
    CLI_INPUT = 3,
    CLI_TOLERANCE = 4
};

enum { CLI_MAX_OPERANDS = 2, CLI_MAX_THREADS = 1024, CLI_MAX_CHANNELS = 64 };

/* The verbs: each parses its arguments (argv[0] is the verb's full name) and returns an exit code. */
int cli_solve(int argc, const char **argv);
int cli_render(int argc, const char **argv);
int cli_probe(int argc, const char **argv);
int cli_formfactors(int argc, const char **argv);
int cli_reference(int argc, const char **argv);
int cli_study(int argc, const char **argv);
int cli_plan(int argc, const char **argv);
int cli_batch(int argc, const char **argv);
int cli_picture(int argc, const char **argv); /* the form without verb */

/* The verb of this name, or NULL. */
typedef int (*cli_function)(int argc, const char **argv);
cli_function cli_find_verb(const char *name);

/* How a verb is called. */
typedef struct cli_verb {
    const char *name;     /* "hprad solve" */
    const char *operands; /* "SCENE.gltf [OPTIONS]" */
    const char *about;    /* printed above the options */
    const char *examples; /* printed below */
    bool solves;          /* then help states the defaults of order and subdivision */
    size_t operand_count;
    const char *operand_names; /* for the message when their number is wrong */
    const struct poptOption *options;
    /* Takes one option of the table; `value` is NULL for a flag and stays valid until cli_finish. Returns
     * false after a message. */
    bool (*take)(void *settings, int id, const char *value);
} cli_verb;

typedef struct cli_progress {
    bool wanted, drawn;
    const char *stage;
    struct timespec stage_start, last_drawn;
    double error, tolerance; /* of the last solve towards a tolerance; 0: none yet */
} cli_progress;

/* One run of a verb, from its arguments to its exit code. */
typedef struct cli_run {
    const cli_verb *verb;
    poptContext options;
    size_t kept_count;
    char **kept; /* option values */
    const char *operand[CLI_MAX_OPERANDS];
    int threads;
    const char *isa;
    bool quiet, verbose;
    hpr_context *context;
    cli_progress progress;
} cli_run;

/* Parses the arguments. CLI_GO_ON, or an exit code after --help, --version or a message. */
int cli_parse(cli_run *run, const cli_verb *verb, void *settings, int argc, const char **argv);

/* Creates the context and begins to listen for signals. CLI_GO_ON, or an exit code after a message. */
int cli_open(cli_run *run);

/* The exit code of a finished job; says what went wrong. */
int cli_conclude(cli_run *run, hpr_status status, hpr_job_step step);

/* Releases everything; accepts a run that has only been parsed. */
void cli_finish(cli_run *run);

/* Says each written file on stdout unless quiet; events.user is the run. */
hpr_job_events cli_events(cli_run *run);

/* Removes the progress bar, so that other text can follow. */
void cli_clear_progress(cli_run *run);
void cli_show_progress(void *run, const char *stage, double fraction);
void cli_show_accuracy(void *run, double error, double tolerance);

/* stderr, with "hprad: " before and a line end behind. */
void cli_complain(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* An output on stdout leaves no room there for anything else: then the run is quiet. */
void cli_mind_stdout(cli_run *run, const char *path);

/* Strict numbers: the whole text, within bounds. False after a message that names option and value. */
bool cli_integer(const char *option, const char *text, int low, int high, int *value);
/* Above 0 and up to `high`, or, if `below`, less than that. */
bool cli_positive(const char *option, const char *text, double high, bool below, double *value);
/* A file name; an empty one is refused. */
bool cli_path(const char *option, const char *text, const char **path);
bool cli_size(const char *option, const char *text, int *width, int *height);

/* Radiance from outside: one number or several with commas between, each from 0. */
typedef struct cli_environment {
    size_t count; /* 0: the option was not given */
    double radiance[CLI_MAX_CHANNELS];
} cli_environment;

/* False after a message if an option was given that has no effect without another. */
bool cli_only_with(const char *option, bool given, bool fits, const char *what);

bool cli_take_environment(const char *text, cli_environment *environment);

/* Signals (signals.c). The flag is the number of the signal that came, 0 if none. */
extern volatile sig_atomic_t cli_signal;
void cli_catch_signals(void);

/* Groups of options that several verbs have (options.c, render_options.c). Their ids do not overlap. */
extern const struct poptOption cli_solve_options[];
extern const struct poptOption cli_method_options[];
extern const struct poptOption cli_render_options[];
extern const struct poptOption cli_common_options[];

typedef struct cli_solve_settings {
    hpr_read_options read;
    hpr_solve_options solve;
    cli_environment environment;
    bool feet_given; /* else --subdivide alone makes all elements */
    bool direct_given, refine_given;
    const char *report_path;
} cli_solve_settings;

typedef struct cli_method_settings {
    hpr_baseline_options baseline;
    bool hemicube_given, rays_given;
} cli_method_settings;

/* Takes an option of the group. -1: it is of another group; 0: refused after a message; 1: taken. */
int cli_take_solve_option(cli_solve_settings *settings, int id, const char *value);
int cli_take_method_option(cli_method_settings *settings, hpr_solve_options *solve, int id,
                           const char *value);
int cli_take_render_option(hpr_job_render_options *settings, int id, const char *value);
int cli_take_common_option(cli_run *run, int id, const char *value);

/* What no single option can tell. False after a message. */
bool cli_check_solve(const cli_solve_settings *settings);
bool cli_check_method(const cli_method_settings *settings, const cli_solve_settings *solve);
bool cli_check_render_options(const hpr_job_render_options *settings);

/* Ids of options. Those of single verbs begin at CLI_OPTION_OWN. */
enum {
    CLI_OPTION_THREADS = 1,
    CLI_OPTION_ISA,
    CLI_OPTION_QUIET,
    CLI_OPTION_VERBOSE,
    CLI_OPTION_VERSION,
    CLI_OPTION_HELP,
    CLI_OPTION_ORDER,
    CLI_OPTION_SUBDIVIDE,
    CLI_OPTION_FEET,
    CLI_OPTION_ELEMENT_SIZE,
    CLI_OPTION_GRADE,
    CLI_OPTION_LINK_TOLERANCE,
    CLI_OPTION_BLOCK_TOLERANCE,
    CLI_OPTION_SOLVER,
    CLI_OPTION_DIRECT,
    CLI_OPTION_ENVIRONMENT,
    CLI_OPTION_MAX_SWEEPS,
    CLI_OPTION_MAX_REFLECTANCE,
    CLI_OPTION_METALLIC,
    CLI_OPTION_SCENE_INDEX,
    CLI_OPTION_REPORT,
    CLI_OPTION_TOLERANCE,
    CLI_OPTION_REFINE,
    CLI_OPTION_MAX_TIME,
    CLI_OPTION_MAX_MEMORY,
    CLI_OPTION_METHOD,
    CLI_OPTION_HEMICUBE,
    CLI_OPTION_RAYS,
    CLI_OPTION_SHOTS,
    CLI_OPTION_EVERY,
    CLI_OPTION_CAMERA,
    CLI_OPTION_SIZE,
    CLI_OPTION_SAMPLES,
    CLI_OPTION_PREVIEW,
    CLI_OPTION_EXPOSURE,
    CLI_OPTION_CAMERA_FILE,
    CLI_OPTION_ORBIT,
    CLI_OPTION_ORBIT_CENTRE,
    CLI_OPTION_FRAMES,
    CLI_OPTION_CROP,
    CLI_OPTION_FILTER,
    CLI_OPTION_FILTER_WIDTH,
    CLI_OPTION_LAYERS,
    CLI_OPTION_HALF,
    CLI_OPTION_TILED,
    CLI_OPTION_FALSE_COLOUR,
    CLI_OPTION_COMPARE,
    CLI_OPTION_OWN
};

#endif
