/* hprad SCENE: solve and render in one go */
#include "cli/cli.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { OPTION_OUTPUT = CLI_OPTION_OWN };

typedef struct settings {
    cli_solve_settings solve;
    hpr_job_render_options render;
} settings;

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the picture; several cameras get _{camera} before the extension unless {camera} or {frame:04} is in "
     "the name (default: the scene's base name with .exr, in the working folder)",
     "out.exr"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_solve_options, 0, "How to solve:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_render_options, 0, "What to show:", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    if (id == OPTION_OUTPUT) {
        chosen->render.pattern = value;
        return true;
    }
    int taken = cli_take_solve_option(&chosen->solve, id, value);
    if (taken < 0)
        taken = cli_take_render_option(&chosen->render, id, value);
    return taken > 0;
}

static const cli_verb verb = {
    .name = "hprad",
    .operands =
        "SCENE.gltf|SCENE.glb [OPTIONS]\n"
        "   or: hprad solve  SCENE [OPTIONS]               scene -> solution\n"
        "   or: hprad render SOL.glb|SCENE [OPTIONS]       solution -> a picture per camera\n"
        "   or: hprad probe  SOL.glb POINTS.csv [OPTIONS]  irradiance and radiosity at points\n"
        "   or: hprad formfactors MODEL [OPTIONS]          view factors between surfaces\n"
        "   or: hprad reference SCENE [OPTIONS]            path tracing: the independent check\n"
        "   or: hprad study SCENE [OPTIONS]                what accuracy costs: sweeps -> CSV\n"
        "   or: hprad plan SCENE [OPTIONS]                 what a scene calls for, and what it costs\n"
        "   or: hprad batch JOBS.json [OPTIONS]            many scenes, many views, resumable\n"
        "       hprad VERB --help                          more on a verb",
    .about = "Diffuse global illumination by higher-order radiosity. Without a verb: solves the scene and\n"
             "renders every camera as an OpenEXR picture of radiance.\n"
             "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 tolerance not reached,\n"
             "130 and 143 interrupted.\n",
    .examples = "  hprad scenes/cornell_box.gltf -o cornell_box.exr --png\n"
                "  hprad solve scenes/furnished_room.gltf -o room.glb --order 2\n"
                "  hprad render room.glb -o 'views/{camera}.exr'\n",
    .operand_count = 1,
    .operand_names = "one scene",
    .solves = true,
    .options = options,
    .take = take,
};

/* A bare word that is no file was meant as a verb. The first one is looked at before the arguments are
 * counted, for a verb that does not exist has arguments of its own. */
static bool check_verb(int argc, const char **argv)
{
    const char *word = argc > 1 ? argv[1] : NULL;
    if (!word) {
        cli_complain("no input: expected a scene or a verb (solve, render, probe, formfactors, reference, "
                     "study, plan, batch); "
                     "see 'hprad --help'");
        return false;
    }
    if (word[0] && word[0] != '-' && !strpbrk(word, "./") && access(word, F_OK) != 0 && errno == ENOENT) {
        cli_complain(
            "'%s' is neither a verb (solve, render, probe, formfactors, reference, study, plan, batch) "
            "nor a file; see "
            "'hprad --help'",
            word);
        return false;
    }
    for (int i = 1; i < argc; i++) {
        if (cli_find_verb(argv[i]) && argv[1][0] == '-') {
            cli_complain("the verb comes first: 'hprad %s ...'", argv[i]);
            return false;
        }
    }
    return true;
}

int cli_picture(int argc, const char **argv)
{
    if (!check_verb(argc, argv))
        return CLI_USAGE;
    settings chosen = {0};
    hpr_read_options_init(&chosen.solve.read);
    hpr_solve_options_init(&chosen.solve.solve);
    hpr_job_render_options_init(&chosen.render);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && (!cli_check_solve(&chosen.solve) || !cli_check_render_options(&chosen.render)))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.render.pattern);
        cli_mind_stdout(&run, chosen.solve.report_path);
        chosen.render.events = cli_events(&run);
        chosen.render.environment_count = chosen.solve.environment.count;
        chosen.render.environment = chosen.solve.environment.radiance;
        chosen.render.report_path = chosen.solve.report_path;
        hpr_job_picture_options job = {
            .read = chosen.solve.read, .solve = chosen.solve.solve, .pictures = chosen.render};
        hpr_job_result result;
        hpr_status status = hpr_job_picture(run.context, run.operand[0], &job, &result);
        code = cli_conclude(&run, status, result.step);
    }
    cli_finish(&run);
    return code;
}
