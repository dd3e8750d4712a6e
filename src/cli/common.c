/* One run of a verb: arguments, context, messages, exit code. */
#include "cli/cli.h"

#include <hprad/version.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void cli_complain(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("hprad: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static int print_help(cli_run *run)
{
    poptPrintHelp(run->options, stdout, 0);
    if (run->verb->solves)
        printf("\nThis version solves with --order %d --subdivide %d --feet %d unless told otherwise, scenes "
               "of many\n"
               "patches with less.\n",
               HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE, HPR_DEFAULT_FEET);
    printf("\n%s\nExample%s:\n%s", run->verb->about, strchr(run->verb->examples, '\n')[1] ? "s" : "",
           run->verb->examples);
    return CLI_DONE;
}

static int print_version(void)
{
    hpr_context *context = NULL;
    hpr_status status = hpr_context_create(NULL, &context);
    if (status != HPR_OK) {
        cli_complain("%s", hpr_status_string(status));
        return CLI_FAILED;
    }
    printf("hprad %s (commit %s)\nEmbree %s\ninstruction set %s\n", hpr_version(), hpr_commit(),
           hpr_embree_version(), hpr_context_isa(context));
    hpr_context_destroy(&context);
    return CLI_DONE;
}

/* Takes over the value of an option. */
static bool keep(cli_run *run, char *value)
{
    char **grown = realloc(run->kept, (run->kept_count + 1) * sizeof *grown);
    if (!grown) {
        free(value);
        cli_complain("out of memory");
        return false;
    }
    run->kept = grown;
    run->kept[run->kept_count++] = value;
    return true;
}

static int take_option(cli_run *run, void *settings, int id)
{
    if (id == CLI_OPTION_HELP)
        return print_help(run);
    if (id == CLI_OPTION_VERSION)
        return print_version();
    char *value = poptGetOptArg(run->options);
    if (value && !keep(run, value))
        return CLI_FAILED;
    int taken = cli_take_common_option(run, id, value);
    if (taken < 0)
        taken = run->verb->take(settings, id, value);
    return taken ? CLI_GO_ON : CLI_USAGE;
}

static int take_operands(cli_run *run)
{
    const cli_verb *verb = run->verb;
    size_t count = 0;
    for (const char *text; (text = poptGetArg(run->options)) != NULL; count++) {
        if (count == verb->operand_count) {
            cli_complain("'%s' is one argument too many: expected %s; see '%s --help'", text,
                         verb->operand_names, verb->name);
            return CLI_USAGE;
        }
        run->operand[count] = text;
    }
    if (count < verb->operand_count) {
        cli_complain("%s: expected %s; see '%s --help'", count ? "an argument is missing" : "no input",
                     verb->operand_names, verb->name);
        return CLI_USAGE;
    }
    for (size_t i = 0; i < count; i++) {
        if (!run->operand[i][0]) {
            cli_complain("'' is no file name: expected %s", verb->operand_names);
            return CLI_USAGE;
        }
    }
    return CLI_GO_ON;
}

int cli_parse(cli_run *run, const cli_verb *verb, void *settings, int argc, const char **argv)
{
    *run = (cli_run){.verb = verb};
    run->options = poptGetContext(NULL, argc, argv, verb->options, 0);
    if (!run->options) {
        cli_complain("out of memory");
        return CLI_FAILED;
    }
    poptSetOtherOptionHelp(run->options, verb->operands);
    int id;
    while ((id = poptGetNextOpt(run->options)) > 0) {
        int code = take_option(run, settings, id);
        if (code != CLI_GO_ON)
            return code;
    }
    if (id < -1) {
        const char *option = poptBadOption(run->options, POPT_BADOPTION_NOALIAS);
        cli_complain("'%s': %s; see '%s --help'", option, poptStrerror(id), verb->name);
        return CLI_USAGE;
    }
    return take_operands(run);
}

static void show_message(void *user, hpr_log_level level, const char *text)
{
    cli_run *run = user;
    if (level == HPR_LOG_INFO && !run->verbose)
        return;
    cli_clear_progress(run);
    cli_complain("%s%s", level == HPR_LOG_WARNING ? "warning: " : "", text);
}

int cli_open(cli_run *run)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = run->threads;
    options.isa = run->isa;
    options.log = show_message;
    options.progress = cli_show_progress;
    options.accuracy = cli_show_accuracy;
    options.user = run;
    options.cancel = &cli_signal;
    run->progress.wanted = !run->quiet && isatty(STDERR_FILENO);
    cli_catch_signals();
    hpr_status status = hpr_context_create(&options, &run->context);
    if (status == HPR_ERR_ARG) {
        cli_complain("--isa '%s': this processor does not have it", run->isa ? run->isa : "auto");
        return CLI_USAGE;
    }
    if (status != HPR_OK) {
        cli_complain("%s", hpr_status_string(status));
        return CLI_FAILED;
    }
    return CLI_GO_ON;
}

static int exit_code(hpr_status status, hpr_job_step step)
{
    switch (status) {
    case HPR_OK:
        return CLI_DONE;
    case HPR_ERR_ARG:
        return CLI_USAGE;
    case HPR_ERR_FORMAT:
    case HPR_ERR_UNSUPPORTED:
        return CLI_INPUT;
    case HPR_ERR_IO:
        return step == HPR_JOB_READ ? CLI_INPUT : CLI_FAILED;
    case HPR_ERR_TOLERANCE:
        return CLI_TOLERANCE;
    default:
        return CLI_FAILED;
    }
}

int cli_conclude(cli_run *run, hpr_status status, hpr_job_step step)
{
    cli_clear_progress(run);
    if (status == HPR_OK)
        return CLI_DONE;
    if (status == HPR_ERR_INTERRUPTED && cli_signal) {
        cli_complain("interrupted by %s", cli_signal == SIGINT ? "SIGINT" : "SIGTERM");
        return 128 + (int)cli_signal;
    }
    const char *text = hpr_context_error(run->context);
    cli_complain("%s", text[0] ? text : hpr_status_string(status));
    return exit_code(status, step);
}

void cli_finish(cli_run *run)
{
    hpr_context_destroy(&run->context);
    for (size_t i = 0; i < run->kept_count; i++)
        free(run->kept[i]);
    free(run->kept);
    poptFreeContext(run->options);
    *run = (cli_run){0};
}

static void say_file(void *user, const hpr_job_file *file)
{
    cli_run *run = user;
    cli_clear_progress(run);
    if (run->quiet)
        return;
    switch (file->kind) {
    case HPR_JOB_FILE_EXR:
        printf("wrote %s (camera %s, %d x %d)\n", file->path, file->camera, file->width, file->height);
        break;
    case HPR_JOB_FILE_PNG:
        printf("wrote %s (camera %s, exposure %.6g)\n", file->path, file->camera, file->exposure);
        break;
    case HPR_JOB_FILE_FALSE_COLOUR:
        printf("wrote %s (camera %s, irradiance 0 to %.6g W/m2)\n", file->path, file->camera, file->top);
        break;
    case HPR_JOB_FILE_DIFFERENCE:
        printf("wrote %s (camera %s minus %s: RMSE %.6g, relMSE %.6g, PSNR %.4g dB)\n", file->path,
               file->camera, file->reference, file->difference->rmse, file->difference->rel_mse,
               file->difference->psnr_db);
        break;
    default:
        printf("wrote %s\n", file->path);
    }
    fflush(stdout);
}

hpr_job_events cli_events(cli_run *run)
{
    return (hpr_job_events){.wrote = say_file, .user = run};
}

void cli_mind_stdout(cli_run *run, const char *path)
{
    struct stat output, standard;
    if (path && stat(path, &output) == 0 && fstat(STDOUT_FILENO, &standard) == 0 &&
        output.st_dev == standard.st_dev && output.st_ino == standard.st_ino)
        run->quiet = true;
}
