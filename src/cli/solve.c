/* hprad solve */
#include "cli/cli.h"

#include <stdio.h>

enum { OPTION_OUTPUT = CLI_OPTION_OWN, OPTION_CHECKPOINT, OPTION_RESUME };

typedef struct settings {
    cli_solve_settings solve;
    cli_method_settings method;
    const char *output, *checkpoint, *resume;
} settings;

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the solution (default: the scene's base name with .glb, in the working folder)", "SOL.glb"},
    {"checkpoint", 0, POPT_ARG_STRING, NULL, OPTION_CHECKPOINT,
     "with --tol: write to FILE, after each of the solves, where the series stands", "FILE"},
    {"resume", 0, POPT_ARG_STRING, NULL, OPTION_RESUME,
     "with --tol: go on where FILE, a checkpoint of the same scene and options, was written", "FILE"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_solve_options, 0, "How to solve:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_method_options, 0,
     "Classical methods, to compare with:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    if (id == OPTION_OUTPUT) {
        chosen->output = value;
        return true;
    }
    if (id == OPTION_CHECKPOINT)
        return cli_path("--checkpoint", value, &chosen->checkpoint);
    if (id == OPTION_RESUME)
        return cli_path("--resume", value, &chosen->resume);
    int taken = cli_take_method_option(&chosen->method, &chosen->solve.solve, id, value);
    if (taken < 0)
        taken = cli_take_solve_option(&chosen->solve, id, value);
    return taken > 0;
}

static const cli_verb verb = {
    .name = "hprad solve",
    .operands = "SCENE.gltf|SCENE.glb [OPTIONS]",
    .about = "Solves a scene once for all views. The solution is a .glb that any glTF viewer shows and that\n"
             "'hprad render' and 'hprad probe' read.\n",
    .examples = "  hprad solve scenes/cornell_box.gltf -o box.glb --order 2 --subdivide 3 --report box.json\n"
                "  hprad solve scenes/cornell_box.gltf --method hemicube --subdivide 3 --solver shooting "
                "--every 100\n",
    .operand_count = 1,
    .operand_names = "one scene",
    .solves = true,
    .options = options,
    .take = take,
};

static bool check_settings(const settings *chosen)
{
    bool adapts = chosen->solve.solve.tolerance > 0;
    return cli_check_solve(&chosen->solve) && cli_check_method(&chosen->method, &chosen->solve) &&
           cli_only_with("--checkpoint", chosen->checkpoint != NULL, adapts, "--tol") &&
           cli_only_with("--resume", chosen->resume != NULL, adapts, "--tol");
}

static void print_summary(const hpr_job_result *result)
{
    const hpr_solve_summary *summary = &result->summary;
    printf("patches   %zu\n", summary->patch_count);
    printf("elements  %zu\n", summary->element_count);
    printf("dofs      %zu\n", summary->dof_count);
    printf("sweeps    %d\n", summary->sweeps);
    printf("residual  %.3g\n", summary->residual);
    if (summary->options.tolerance > 0)
        printf("error     %.2e estimated\n", summary->error_estimate);
    printf("seconds   %.2f\n", result->seconds);
}

int cli_solve(int argc, const char **argv)
{
    settings chosen = {0};
    hpr_read_options_init(&chosen.solve.read);
    hpr_solve_options_init(&chosen.solve.solve);
    hpr_baseline_options_init(&chosen.method.baseline);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && !check_settings(&chosen))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.output);
        cli_mind_stdout(&run, chosen.solve.report_path);
        hpr_job_solve_options job = {.solution_path = chosen.output,
                                     .report_path = chosen.solve.report_path,
                                     .checkpoint_path = chosen.checkpoint,
                                     .resume_path = chosen.resume,
                                     .read = chosen.solve.read,
                                     .solve = chosen.solve.solve,
                                     .baseline = chosen.method.baseline,
                                     .environment_count = chosen.solve.environment.count,
                                     .environment = chosen.solve.environment.radiance,
                                     .events = cli_events(&run)};
        hpr_job_result result;
        hpr_status status = hpr_job_solve(run.context, run.operand[0], &job, &result);
        code = cli_conclude(&run, status, result.step);
        if ((status == HPR_OK || status == HPR_ERR_TOLERANCE) && !run.quiet)
            print_summary(&result);
    }
    cli_finish(&run);
    return code;
}
