/* hprad render */
#include "cli/cli.h"

enum { OPTION_OUTPUT = CLI_OPTION_OWN, OPTION_ENVIRONMENT, OPTION_REPORT };

typedef struct settings {
    hpr_job_render_options job;
    cli_environment environment;
} settings;

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the pictures; {camera} and {frame:04} are replaced (default: the input's base name with .exr, in the "
     "working folder)",
     "OUT.exr"},
    {"environment", 0, POPT_ARG_STRING, NULL, OPTION_ENVIRONMENT,
     "of a scene that is solved first: uniform radiance from outside, W/m2/sr (a solution has its own)", "L"},
    {"report", 0, POPT_ARG_STRING, NULL, OPTION_REPORT, "write what was done and what it cost as JSON",
     "R.json"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_render_options, 0, "What to show:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    if (id == OPTION_ENVIRONMENT)
        return cli_take_environment(value, &chosen->environment);
    if (id == OPTION_REPORT)
        return cli_path("--report", value, &chosen->job.report_path);
    if (id != OPTION_OUTPUT)
        return cli_take_render_option(&chosen->job, id, value) > 0;
    chosen->job.pattern = value;
    return true;
}

static const cli_verb verb = {
    .name = "hprad render",
    .operands = "SOL.glb|SCENE [OPTIONS]",
    .about =
        "Renders the cameras of a solution as OpenEXR pictures of radiance. A scene is solved first, with\n"
        "default settings. In the output name {camera} is the camera's name (\"/\" becomes \"_\", no name\n"
        "\"camera0\", a repeated name gets _1) and {frame} or {frame:04} the number of the picture from 0.\n"
        "One name for several cameras is refused.\n",
    .examples = "  hprad render box.glb -o 'views/{camera}.exr' --png --samples 16\n"
                "  hprad render box.glb -o door.exr --camera door --size 1920x1080\n"
                "  hprad render box.glb -o 'turn/{frame:04}.exr' --camera 0 --orbit 100\n",
    .operand_count = 1,
    .operand_names = "one solution or scene",
    .options = options,
    .take = take,
};

int cli_render(int argc, const char **argv)
{
    settings chosen = {0};
    hpr_job_render_options_init(&chosen.job);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && !cli_check_render_options(&chosen.job))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.job.pattern);
        cli_mind_stdout(&run, chosen.job.report_path);
        chosen.job.events = cli_events(&run);
        chosen.job.environment_count = chosen.environment.count;
        chosen.job.environment = chosen.environment.radiance;
        hpr_job_result result;
        hpr_status status = hpr_job_render(run.context, run.operand[0], &chosen.job, &result);
        code = cli_conclude(&run, status, result.step);
    }
    cli_finish(&run);
    return code;
}
