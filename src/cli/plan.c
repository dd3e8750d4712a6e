/* hprad plan */
#include "cli/cli.h"

#include <hprad/plan.h>
#include <math.h>
#include <stdio.h>

enum { OPTION_MEASURE = CLI_OPTION_OWN };

typedef struct settings {
    cli_solve_settings solve;
    int measure;
} settings;

static const struct poptOption options[] = {
    {"measure", 0, POPT_ARG_NONE, NULL, OPTION_MEASURE,
     "also solve what is predicted to stay within --max-time (60 CPU seconds each) and --max-memory (half of "
     "the "
     "machine's), and compare",
     NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_solve_options, 0, "How it would be solved:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    if (id == OPTION_MEASURE) {
        chosen->measure = 1;
        return true;
    }
    return cli_take_solve_option(&chosen->solve, id, value) > 0;
}

static const cli_verb verb = {
    .name = "hprad plan",
    .operands = "SCENE.gltf|SCENE.glb [OPTIONS]",
    .about = "What does a scene call for, what is left out, and what will it cost? Reads the scene and "
             "classifies\n"
             "what sees what; nothing is solved without --measure. Predictions are for the default, and for "
             "--tol\n"
             "1e-1, 1e-2 and 1e-3 or the one that is given. --report writes the same as JSON.\n",
    .examples = "  hprad plan scenes/cornell_box.gltf\n"
                "  hprad plan scenes/cube_mixed.gltf --measure --max-time 10 --report plan.json\n",
    .operand_count = 1,
    .operand_names = "one scene",
    .options = options,
    .take = take,
};

static void print_effects(const hpr_plan *plan)
{
    for (int called = 1; called >= 0; called--) {
        puts(called ? "called for" : "left out");
        for (int i = 0; i < HPR_PLAN_EFFECTS; i++) {
            if (plan->effect[i].called_for == called)
                printf("  %-16s %s\n", plan->effect[i].name, plan->effect[i].why);
        }
    }
    bool estimated = plan->pairs_drawn < plan->pairs;
    printf("patches   %zu\n", plan->patch_count);
    printf("pairs     %s%.4g hidden, %s%.4g visible, %s%.4g partly", estimated ? "~" : "", plan->pairs_hidden,
           estimated ? "~" : "", plan->pairs_visible, estimated ? "~" : "", plan->pairs_partial);
    if (plan->pairs_partial > 0)
        printf(", %.3g of %zu occluders between", plan->blocker_count, plan->occluder_count);
    putchar('\n');
}

static void print_cost(const char *kind, const hpr_plan_cost *cost)
{
    printf("%-9s %10.0f %10.0f %10.0f %10.0f %10.2f", kind, cost->elements, cost->dofs, cost->links,
           1e-6 * cost->memory_bytes, cost->cpu_s);
}

static void print_solves(const hpr_plan *plan, int measure)
{
    printf("\n%-8s %-9s %10s %10s %10s %10s %10s\n", "tol", "", "elements", "dofs", "links", "memory MB",
           "CPU s");
    for (size_t i = 0; i < plan->solve_count; i++) {
        const hpr_plan_solve *solve = &plan->solve[i];
        char tolerance[16] = "default";
        if (solve->tolerance > 0)
            snprintf(tolerance, sizeof tolerance, "%.0e", solve->tolerance);
        printf("%-8s ", tolerance);
        print_cost("predicted", &solve->predicted);
        putchar('\n');
        if (solve->too_large)
            printf("%-8s too large for this machine: it would be refused\n", "");
        else if (solve->measured) {
            printf("%-8s ", "");
            print_cost("measured", &solve->cost);
            if (!isnan(solve->error))
                printf("  error %.1e estimated", solve->error);
            putchar('\n');
        } else if (measure) {
            printf("%-8s not measured: beyond --max-time or --max-memory\n", "");
        }
    }
}

static void print_plan(const hpr_plan *plan, int measure)
{
    print_effects(plan);
    print_solves(plan, measure);
    if (plan->least_bytes > 0)
        printf("too large: the operator of the first takes at least %.3g GB; 'hprad solve' refuses it "
               "without --max-memory\n",
               1e-9 * plan->least_bytes);
}

static bool check(const settings *chosen)
{
    const hpr_solve_options *solve = &chosen->solve.solve;
    return cli_only_with("--max-time", solve->max_seconds > 0, chosen->measure, "--measure") &&
           cli_only_with("--max-memory", solve->max_bytes > 0, chosen->measure, "--measure");
}

int cli_plan(int argc, const char **argv)
{
    settings chosen = {0};
    hpr_read_options_init(&chosen.solve.read);
    hpr_solve_options_init(&chosen.solve.solve);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && !check(&chosen))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.solve.report_path);
        hpr_job_plan_options job = {.report_path = chosen.solve.report_path,
                                    .read = chosen.solve.read,
                                    .solve = chosen.solve.solve,
                                    .environment_count = chosen.solve.environment.count,
                                    .environment = chosen.solve.environment.radiance,
                                    .measure = chosen.measure,
                                    .events = cli_events(&run)};
        hpr_plan plan;
        hpr_job_result result;
        hpr_status status = hpr_job_plan(run.context, run.operand[0], &job, &plan, &result);
        code = cli_conclude(&run, status, result.step);
        if (status == HPR_OK && !run.quiet)
            print_plan(&plan, chosen.measure);
    }
    cli_finish(&run);
    return code;
}
