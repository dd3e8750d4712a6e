/* hprad study */
#include "cli/cli.h"

#include <hprad/study.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    OPTION_OUTPUT = CLI_OPTION_OWN,
    OPTION_JSON,
    OPTION_ORDERS,
    OPTION_SUBDIVIDE,
    OPTION_METHOD,
    OPTION_DIRECT,
    OPTION_REFINE,
    OPTION_TOLERANCES,
    OPTION_TRUTH,
    OPTION_POINTS,
    OPTION_REPEATS,
    OPTION_RESUME
};

enum { MOST = 64 }; /* entries of a list */

typedef struct settings {
    cli_solve_settings solve;
    cli_method_settings method;
    hpr_job_study_options job;
    int order[MOST], subdivide[MOST];
    hpr_method methods[MOST];
    hpr_direct_mode direct[MOST];
    double tolerance[MOST];
} settings;

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the table (default: the scene's base name with _study.csv, in the working folder)", "OUT.csv"},
    {"json", 0, POPT_ARG_STRING, NULL, OPTION_JSON, "write the rows as JSON too", "OUT.json"},
    {"orders", 0, POPT_ARG_STRING, NULL, OPTION_ORDERS,
     "polynomial degrees: FIRST:LAST, or numbers with commas between (default 0:4)", "LIST"},
    {"subdivide", 0, POPT_ARG_STRING, NULL, OPTION_SUBDIVIDE, "subdivisions, likewise (default 0:2)", "LIST"},
    {"refine", 0, POPT_ARG_STRING, NULL, OPTION_REFINE,
     "h: every order on every subdivision; p: every order on the first; hp: order p with --grade p on the "
     "first (default h). With --tol the adaptive solves too: halve elements, raise degrees, or both "
     "(default hp)",
     "LIST"},
    {"tol", 0, POPT_ARG_STRING, NULL, OPTION_TOLERANCES,
     "further solves of galerkin, and of hierarchical by halving, refined to these tolerances as 'hprad "
     "solve "
     "--tol' is; numbers with commas between",
     "LIST"},
    {"method", 0, POPT_ARG_STRING, NULL, OPTION_METHOD,
     "galerkin, hierarchical, hemicube, raycast, exact; see 'hprad solve' (default galerkin)", "LIST"},
    {"direct", 0, POPT_ARG_STRING, NULL, OPTION_DIRECT,
     "direct light of galerkin: exact, evaluated at points, or galerkin, through the basis (default exact)",
     "LIST"},
    {"truth", 0, POPT_ARG_STRING, NULL, OPTION_TRUTH,
     "what is compared with: a solution of the scene, SOL.glb, or order and subdivision, P,N, or the "
     "tolerance, E, of one that is made (default: finer than all runs, up to 12,000 coefficients; with --tol "
     "a fifth of the least)",
     "TRUTH"},
    {"points", 0, POPT_ARG_STRING, NULL, OPTION_POINTS,
     "compare at these points too, as 'hprad probe' takes them; where the table has the irradiance there, as "
     "irradiance_r,..., with that",
     "POINTS.csv"},
    {"repeats", 0, POPT_ARG_STRING, NULL, OPTION_REPEATS,
     "solve N times and once before to warm up; times are medians (default 1, without)", "N"},
    {"resume", 0, POPT_ARG_NONE, NULL, OPTION_RESUME,
     "take over the rows that the table has already, of the same settings and version", NULL},
    {"max-time", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_TIME,
     "with --tol: begin no refinement that would probably end later than S seconds after the first", "S"},
    {"feet", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FEET,
     "quarter elements that the foot of an object cuts, N times, 0 to 6 (default 0)", "N"},
    {"environment", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ENVIRONMENT,
     "uniform radiance from outside, W/m2/sr: one number, or one per channel, as R,G,B (default 0)", "L"},
    {"link-tol", 0, POPT_ARG_STRING, NULL, CLI_OPTION_LINK_TOLERANCE,
     "what links between groups of elements may leave out; of galerkin and hierarchical", "T"},
    {"block-tol", 0, POPT_ARG_STRING, NULL, CLI_OPTION_BLOCK_TOLERANCE,
     "relative tolerance of each transport block; of galerkin, hierarchical and exact", "T"},
    {"solver", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SOLVER,
     "how the linear systems are solved; see 'hprad solve' (default auto)", "NAME"},
    {"hemicube", 0, POPT_ARG_STRING, NULL, CLI_OPTION_HEMICUBE,
     "pixels along an edge of the hemicube, an even number up to 4096 (default 256)", "N"},
    {"rays", 0, POPT_ARG_STRING, NULL, CLI_OPTION_RAYS,
     "of ray casting: N x N discs per sender, 1 to 64 (default 2)", "N"},
    {"shots", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SHOTS,
     "with --solver shooting, of classical methods: end after N shots (default: when it has converged)", "N"},
    {"max-reflectance", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_REFLECTANCE,
     "scale reflectances above R down to R", "R"},
    {"metallic", 0, POPT_ARG_STRING, NULL, CLI_OPTION_METALLIC,
     "how the metallic part of a material reflects: diffuse or black (default diffuse)", "WAY"},
    {"scene-index", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SCENE_INDEX,
     "which scene of the file, from 0 (default: the file's choice)", "N"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

/* FIRST:LAST, or A,B,C; rising. */
static bool take_numbers(const char *option, const char *text, int high, int *list, size_t *count)
{
    char copy[4 * MOST], *rest = copy, *colon;
    *count = 0;
    if (strlen(text) >= sizeof copy) {
        cli_complain("%s: the list is too long", option);
        return false;
    }
    strcpy(copy, text);
    if ((colon = strchr(copy, ':')) != NULL) {
        int first, last;
        *colon = 0;
        if (!cli_integer(option, copy, 0, high, &first) ||
            !cli_integer(option, colon + 1, first, high, &last))
            return false;
        for (int value = first; value <= last; value++)
            list[(*count)++] = value;
        return true;
    }
    for (char *word; (word = strsep(&rest, ",")) != NULL; (*count)++) {
        if (*count == MOST) {
            cli_complain("%s: the list is too long", option);
            return false;
        }
        if (!cli_integer(option, word, *count ? list[*count - 1] + 1 : 0, high, &list[*count]))
            return false;
    }
    return true;
}

/* Calls `take` for each word between commas; false as soon as one is refused. */
static bool take_words(settings *chosen, const char *option, const char *text,
                       bool (*take)(settings *chosen, const char *word))
{
    char copy[16 * MOST], *rest = copy;
    if (strlen(text) >= sizeof copy) {
        cli_complain("%s: the list is too long", option);
        return false;
    }
    strcpy(copy, text);
    for (char *word; (word = strsep(&rest, ",")) != NULL;) {
        if (!take(chosen, word))
            return false;
    }
    return true;
}

static bool take_method(settings *chosen, const char *word)
{
    for (int i = HPR_METHOD_GALERKIN; i <= HPR_METHOD_EXACT && chosen->job.method_count < MOST; i++) {
        if (!strcmp(word, hpr_method_name((hpr_method)i))) {
            chosen->methods[chosen->job.method_count++] = (hpr_method)i;
            return true;
        }
    }
    cli_complain("--method '%s': expected galerkin, hierarchical, hemicube, raycast or exact", word);
    return false;
}

static bool take_direct(settings *chosen, const char *word)
{
    bool exact = !strcmp(word, "exact");
    if ((!exact && strcmp(word, "galerkin") != 0) || chosen->job.direct_count == MOST) {
        cli_complain("--direct '%s': expected exact or galerkin", word);
        return false;
    }
    chosen->direct[chosen->job.direct_count++] = exact ? HPR_DIRECT_EXACT : HPR_DIRECT_GALERKIN;
    return true;
}

static bool take_tolerance(settings *chosen, const char *word)
{
    hpr_job_study_options *job = &chosen->job;
    if (job->tolerance_count == MOST) {
        cli_complain("--tol: the list is too long");
        return false;
    }
    return cli_positive("--tol", word, 1, true, &chosen->tolerance[job->tolerance_count++]);
}

static bool take_refine(settings *chosen, const char *word)
{
    static const char *const names[] = {"h", "p", "hp"};
    for (int i = 0; i < 3; i++) {
        if (!strcmp(word, names[i])) {
            chosen->job.refine |= 1 << i;
            chosen->job.adapt = chosen->job.refine;
            return true;
        }
    }
    cli_complain("--refine '%s': expected h, p or hp", word);
    return false;
}

/* P,N if it begins with a digit and has a comma, a tolerance if it is a number, else a file. */
static bool take_truth(settings *chosen, const char *text)
{
    char order[16];
    const char *comma = strchr(text, ',');
    size_t length = comma ? (size_t)(comma - text) : 0;
    if (text[0] && !comma && strspn(text, "0123456789.+-eE") == strlen(text))
        return cli_positive("--truth", text, 1, true, &chosen->job.truth_tolerance);
    if (!length || length >= sizeof order || strspn(text, "0123456789,") < strlen(text))
        return cli_path("--truth", text, &chosen->job.truth_path);
    memcpy(order, text, length);
    order[length] = 0;
    return cli_integer("--truth", order, 0, HPR_MAX_ORDER, &chosen->job.truth_order) &&
           cli_integer("--truth", comma + 1, 0, HPR_MAX_SUBDIVIDE, &chosen->job.truth_subdivide);
}

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    hpr_job_study_options *job = &chosen->job;
    switch (id) {
    case OPTION_OUTPUT:
        return cli_path("--output", value, &job->table_path);
    case OPTION_JSON:
        return cli_path("--json", value, &job->json_path);
    case OPTION_ORDERS:
        job->order = chosen->order;
        return take_numbers("--orders", value, HPR_MAX_ORDER, chosen->order, &job->order_count);
    case OPTION_SUBDIVIDE:
        job->subdivide = chosen->subdivide;
        return take_numbers("--subdivide", value, HPR_MAX_SUBDIVIDE, chosen->subdivide,
                            &job->subdivide_count);
    case OPTION_METHOD:
        job->method = chosen->methods;
        job->method_count = 0;
        return take_words(chosen, "--method", value, take_method);
    case OPTION_DIRECT:
        job->direct = chosen->direct;
        job->direct_count = 0;
        return take_words(chosen, "--direct", value, take_direct);
    case OPTION_REFINE:
        job->refine = 0;
        return take_words(chosen, "--refine", value, take_refine);
    case OPTION_TOLERANCES:
        job->tolerance = chosen->tolerance;
        job->tolerance_count = 0;
        return take_words(chosen, "--tol", value, take_tolerance);
    case OPTION_TRUTH:
        return take_truth(chosen, value);
    case OPTION_POINTS:
        return cli_path("--points", value, &job->points_path);
    case OPTION_REPEATS:
        return cli_integer("--repeats", value, 1, 1000, &job->repeats);
    case OPTION_RESUME:
        job->resume = 1;
        return true;
    default:
        break;
    }
    int taken = cli_take_method_option(&chosen->method, &chosen->solve.solve, id, value);
    if (taken < 0)
        taken = cli_take_solve_option(&chosen->solve, id, value);
    return taken > 0;
}

static const cli_verb verb = {
    .name = "hprad study",
    .operands = "SCENE.gltf|SCENE.glb [OPTIONS]",
    .about =
        "What does accuracy cost? Solves a scene with many orders, subdivisions and methods, and compares\n"
        "each solution with a better one: a table of CSV with counts, times, memory and errors, one row\n"
        "per solve. It is written after each row; --resume goes on where it ended.\n",
    .examples =
        "  hprad study scenes/parallel_plates.gltf --orders 0:12 --subdivide 0 --truth 16,1 -o p.csv\n"
        "  hprad study scenes/cornell_box.gltf --method galerkin,hemicube,raycast --orders 1:3 --repeats 3\n"
        "  hprad study scenes/cornell_box.gltf --tol 1e-1,1e-2 --orders 1 --truth 5,2 -o adaptive.csv\n",
    .operand_count = 1,
    .operand_names = "one scene",
    .options = options,
    .take = take,
};

static void say_row(void *user, const hpr_study_row *row, size_t done, size_t total, double left_s)
{
    cli_run *run = user;
    cli_clear_progress(run);
    if (run->quiet)
        return;
    int left = left_s < 360000 ? (int)(left_s + 0.5) : 360000;
    fprintf(stderr, "%zu/%zu  %-12s ", done, total, hpr_method_name(row->run.method));
    if (row->run.tolerance > 0)
        fprintf(stderr, "tol %-8.1e %-6s", row->run.tolerance, hpr_refine_name(row->run.adapt));
    else
        fprintf(stderr, "p %-2d N %d grade %-2d", row->run.order, row->run.subdivide, row->run.grade);
    fprintf(stderr, "  L2 %.2e  %.2f s CPU", row->error_l2, row->cpu_s);
    if (done < total)
        fprintf(stderr, "  ETA %d:%02d:%02d", left / 3600, left / 60 % 60, left % 60);
    fputc('\n', stderr);
}

int cli_study(int argc, const char **argv)
{
    settings chosen = {0};
    hpr_job_study_options_init(&chosen.job);
    hpr_read_options_init(&chosen.solve.read);
    hpr_solve_options_init(&chosen.solve.solve);
    hpr_baseline_options_init(&chosen.method.baseline);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && !cli_only_with("--max-time", chosen.solve.solve.max_seconds > 0,
                                            chosen.job.tolerance_count > 0, "--tol"))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        hpr_job_study_options *job = &chosen.job;
        cli_mind_stdout(&run, job->table_path);
        cli_mind_stdout(&run, job->json_path);
        job->read = chosen.solve.read;
        job->solve = chosen.solve.solve;
        job->baseline = chosen.method.baseline;
        job->environment_count = chosen.solve.environment.count;
        job->environment = chosen.solve.environment.radiance;
        job->ran = say_row;
        job->events = cli_events(&run);
        hpr_job_result result;
        hpr_status status = hpr_job_study(run.context, run.operand[0], job, &result);
        code = cli_conclude(&run, status, result.step);
        if (status == HPR_OK && !run.quiet)
            printf("seconds   %.2f\n", result.seconds);
    }
    cli_finish(&run);
    return code;
}
