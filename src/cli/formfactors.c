/* hprad formfactors */
#include "cli/cli.h"

#include <limits.h>
#include <stdio.h>

enum { MAX_ORDER = 16 };

enum {
    OPTION_OUTPUT = CLI_OPTION_OWN,
    OPTION_TOLERANCE,
    OPTION_ORDER,
    OPTION_USE_EPS,
    OPTION_SCENE_INDEX,
    OPTION_REPORT
};

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the matrix, as .npy, .csv or .txt (default: the model's base name with .npy, in the working folder)",
     "F.npy"},
    {"tol", 0, POPT_ARG_STRING, NULL, OPTION_TOLERANCE, "relative tolerance of each entry (default 1e-9)",
     "E"},
    {"order", 0, POPT_ARG_STRING, NULL, OPTION_ORDER,
     "kernel blocks of this degree instead of view factors, 0 to 16, as .npy", "P"},
    {"use-eps", 0, POPT_ARG_NONE, NULL, OPTION_USE_EPS, "take the tolerance from a .vs3 file that has eps",
     NULL},
    {"scene-index", 0, POPT_ARG_STRING, NULL, OPTION_SCENE_INDEX,
     "which scene of a glTF file, from 0 (default: the file's choice)", "N"},
    {"report", 0, POPT_ARG_STRING, NULL, OPTION_REPORT,
     "write what was done, how exactly and at what cost as JSON", "R.json"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    hpr_job_form_factors_options *chosen = user;
    switch (id) {
    case OPTION_OUTPUT:
        chosen->output_path = value;
        return true;
    case OPTION_TOLERANCE:
        return cli_positive("--tol", value, 1, true, &chosen->tolerance);
    case OPTION_ORDER:
        return cli_integer("--order", value, 0, MAX_ORDER, &chosen->order);
    case OPTION_USE_EPS:
        chosen->use_eps = 1;
        return true;
    case OPTION_REPORT:
        return cli_path("--report", value, &chosen->report_path);
    default:
        return cli_integer("--scene-index", value, 0, INT_MAX, &chosen->read.scene_index);
    }
}

static const cli_verb verb = {
    .name = "hprad formfactors",
    .operands = "MODEL.gltf|MODEL.glb|MODEL.vs3 [OPTIONS]",
    .about =
        "View factors: F[i][j] is the part of what leaves surface i that reaches surface j. Reads glTF and\n"
        "View3D's .vs3 (formats 3 and 3a; S, O, M, N, base, cmb; encl, emit). .npy is float64, .csv square\n"
        "without header, .txt View3D's layout; NAME.surfaces.csv beside it says what the rows are.\n",
    .examples = "  hprad formfactors scenes/window_room.vs3 -o room.npy --tol 1e-10\n"
                "  hprad formfactors scenes/furnace_cube.gltf -o blocks.npy --order 2\n",
    .operand_count = 1,
    .operand_names = "one model",
    .options = options,
    .take = take,
};

static void say_plan(void *user, size_t row_count, double bytes)
{
    const cli_run *run = user;
    if (run->quiet)
        return;
    printf("surfaces  %zu\nmemory    %.3g MB\n", row_count, 1e-6 * bytes);
    fflush(stdout);
}

static void print_summary(const hpr_job_result *result)
{
    printf("closure   %.2g\n", result->closure_defect);
    printf("seconds   %.2f\n", result->seconds);
}

int cli_formfactors(int argc, const char **argv)
{
    hpr_job_form_factors_options chosen;
    hpr_job_form_factors_options_init(&chosen);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.output_path);
        cli_mind_stdout(&run, chosen.report_path);
        chosen.events = cli_events(&run);
        chosen.planned = say_plan;
        hpr_job_result result;
        hpr_status status = hpr_job_form_factors(run.context, run.operand[0], &chosen, &result);
        code = cli_conclude(&run, status, result.step);
        if ((status == HPR_OK || status == HPR_ERR_TOLERANCE) && !run.quiet)
            print_summary(&result);
    }
    cli_finish(&run);
    return code;
}
