/* hprad reference */
#include "cli/cli.h"

#include <limits.h>
#include <stdio.h>

enum { OPTION_OUTPUT = CLI_OPTION_OWN, OPTION_PATHS, OPTION_SEED };

typedef struct settings {
    cli_solve_settings scene; /* how it is read, and the report */
    hpr_job_reference_options job;
} settings;

static const struct poptOption options[] = {
    {"output", 'o', POPT_ARG_STRING, NULL, OPTION_OUTPUT,
     "the pictures; {camera} and {frame:04} are replaced (default: the scene's base name with "
     "_reference.exr, in the working folder)",
     "OUT.exr"},
    {"samples", 0, POPT_ARG_STRING, NULL, OPTION_PATHS, "paths per pixel, from 2 (default 64)", "N"},
    {"seed", 0, POPT_ARG_STRING, NULL, OPTION_SEED,
     "another number gives other noise around the same mean (default 0)", "N"},
    {"environment", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ENVIRONMENT,
     "uniform radiance from outside, W/m2/sr, seen by surfaces and cameras: one number, or one per channel, "
     "as R,G,B (default 0)",
     "L"},
    {"camera", 0, POPT_ARG_STRING, NULL, CLI_OPTION_CAMERA,
     "one camera, by name or index, or all (default all)", "NAME"},
    {"size", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SIZE, "pixels (default: 512 high, width from the camera)",
     "WxH"},
    {"png", 0, POPT_ARG_NONE, NULL, CLI_OPTION_PREVIEW, "write an 8-bit preview beside each EXR", NULL},
    {"exposure", 0, POPT_ARG_STRING, NULL, CLI_OPTION_EXPOSURE,
     "factor on the radiance in previews (default: chosen for each, and stated)", "X"},
    {"max-reflectance", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_REFLECTANCE,
     "scale reflectances above R down to R", "R"},
    {"metallic", 0, POPT_ARG_STRING, NULL, CLI_OPTION_METALLIC,
     "how the metallic part of a material reflects: diffuse or black (default diffuse)", "WAY"},
    {"scene-index", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SCENE_INDEX,
     "which scene of the file, from 0 (default: the file's choice)", "N"},
    {"report", 0, POPT_ARG_STRING, NULL, CLI_OPTION_REPORT, "write what was done and what it cost as JSON",
     "R.json"},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take(void *user, int id, const char *value)
{
    settings *chosen = user;
    int seed;
    switch (id) {
    case OPTION_OUTPUT:
        chosen->job.pictures.pattern = value;
        return true;
    case OPTION_PATHS:
        return cli_integer("--samples", value, 2, HPR_MAX_PATHS, &chosen->job.pictures.render.samples);
    case OPTION_SEED:
        if (!cli_integer("--seed", value, 0, INT_MAX, &seed))
            return false;
        chosen->job.reference.seed = (uint64_t)seed;
        return true;
    default:
        break;
    }
    int taken = cli_take_render_option(&chosen->job.pictures, id, value);
    if (taken < 0)
        taken = cli_take_solve_option(&chosen->scene, id, value);
    return taken > 0;
}

static const cli_verb verb = {
    .name = "hprad reference",
    .operands = "SCENE.gltf|SCENE.glb [OPTIONS]",
    .about =
        "Renders the cameras of a scene by Monte Carlo path tracing, which shares nothing with the solver\n"
        "but the scene, the camera and the rays: the independent check. Unbiased, noisy; the layer\n"
        "variance (variance.R, variance.G, variance.B) holds the square of each pixel's standard error.\n"
        "Four times the paths halve the noise. The same bits for any number of threads.\n",
    .examples = "  hprad reference scenes/cornell_box.gltf -o truth.exr --samples 256 --png\n"
                "  hprad reference room.gltf -o 'truth/{camera}.exr' --size 320x240 --seed 1\n",
    .operand_count = 1,
    .operand_names = "one scene",
    .options = options,
    .take = take,
};

static void print_summary(const hpr_job_result *result)
{
    printf("rays      %.4g\n", (double)result->ray_count);
    printf("noise     %.3g %%\n", 100 * result->noise);
    printf("seconds   %.2f\n", result->seconds);
}

int cli_reference(int argc, const char **argv)
{
    settings chosen = {0};
    hpr_job_reference_options_init(&chosen.job);
    hpr_read_options_init(&chosen.scene.read);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON && !cli_check_render_options(&chosen.job.pictures))
        code = CLI_USAGE;
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        cli_mind_stdout(&run, chosen.job.pictures.pattern);
        cli_mind_stdout(&run, chosen.scene.report_path);
        chosen.job.read = chosen.scene.read;
        chosen.job.pictures.report_path = chosen.scene.report_path;
        chosen.job.pictures.environment_count = chosen.scene.environment.count;
        chosen.job.pictures.environment = chosen.scene.environment.radiance;
        chosen.job.pictures.events = cli_events(&run);
        hpr_job_result result;
        hpr_status status = hpr_job_reference(run.context, run.operand[0], &chosen.job, &result);
        code = cli_conclude(&run, status, result.step);
        if (status == HPR_OK && !run.quiet)
            print_summary(&result);
    }
    cli_finish(&run);
    return code;
}
