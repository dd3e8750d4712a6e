/* hprad probe */
#include "cli/cli.h"

enum { OPTION_OUTPUT = CLI_OPTION_OWN, OPTION_GATHER };

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT, "the table (default: standard output)", "OUT.csv"},
    {"gather", 0, POPT_ARG_NONE, NULL, OPTION_GATHER,
     "integrate anew at each point what the solution's surfaces send there: slower, and closer to the truth "
     "where elements are coarse",
     NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    hpr_job_probe_options *chosen = user;
    if (id == OPTION_OUTPUT)
        chosen->output_path = value;
    if (id == OPTION_GATHER)
        chosen->gather = 1;
    return true;
}

static const cli_verb verb = {
    .name = "hprad probe",
    .operands = "SOL.glb POINTS.csv [OPTIONS]",
    .about = "Irradiance and radiosity at points of a solution's surfaces, W/m2. The input has the columns\n"
             "x,y,z,nx,ny,nz (metres; the normal chooses the side); the output repeats them and adds\n"
             "irradiance, radiosity, patch and status. A point on no patch has NaN and status nomatch.\n",
    .examples = "  hprad probe box.glb points.csv -o irradiance.csv\n",
    .operand_count = 2,
    .operand_names = "a solution and a table of points",
    .options = options,
    .take = take,
};

int cli_probe(int argc, const char **argv)
{
    hpr_job_probe_options chosen;
    hpr_job_probe_options_init(&chosen);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.output_path);
        chosen.events = cli_events(&run);
        hpr_job_result result;
        hpr_status status = hpr_job_probe(run.context, run.operand[0], run.operand[1], &chosen, &result);
        code = cli_conclude(&run, status, result.step);
        if (status == HPR_OK && result.matched_count < result.point_count)
            cli_complain("warning: %zu of %zu points lie on no patch (status nomatch)",
                         result.point_count - result.matched_count, result.point_count);
    }
    cli_finish(&run);
    return code;
}
