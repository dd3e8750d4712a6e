/* The options about pictures, which several verbs have. */
#include "cli/cli.h"

#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As the renderer has them; refused here before the solve and not after it. */
enum { MAX_SAMPLES = 4096, MAX_FILTER_WIDTH = 16, MAX_ORBIT = 1000000 };

const struct poptOption cli_render_options[] = {
    {"camera", 0, POPT_ARG_STRING, NULL, CLI_OPTION_CAMERA,
     "one camera, by name or index, or all (default all)", "NAME"},
    {"camera-file", 0, POPT_ARG_STRING, NULL, CLI_OPTION_CAMERA_FILE,
     "a glTF file whose cameras take the place of the scene's", "FILE"},
    {"orbit", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ORBIT,
     "N pictures around the scene: the chosen camera, turned about the vertical through the scene's centre",
     "N"},
    {"orbit-centre", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ORBIT_CENTRE, "another centre for that, metres",
     "X,Y,Z"},
    {"frames", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FRAMES,
     "only these pictures, by the numbers that {frame} has", "A|A-B"},
    {"size", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SIZE, "pixels (default: 512 high, width from the camera)",
     "WxH"},
    {"crop", 0, POPT_ARG_STRING, NULL, CLI_OPTION_CROP,
     "X0,Y0,X1,Y1: only the pixels X0 <= x < X1, Y0 <= y < Y1 of the picture", "BOX"},
    {"samples", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SAMPLES, "rays per pixel (default 4)", "N"},
    {"filter", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FILTER,
     "how rays are spread around a pixel's centre: box or gaussian (default box)", "NAME"},
    {"filter-width", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FILTER_WIDTH,
     "width of the whole filter, up to 16 pixels (default 1, of gaussian 3: six standard deviations)", "W"},
    {"aov", 0, POPT_ARG_STRING, NULL, CLI_OPTION_LAYERS,
     "more layers in the EXR, any of: irradiance, direct, indirect, emission, albedo, N, P, Z, degree, "
     "error, patchId, elementId",
     "A,B,..."},
    {"half", 0, POPT_ARG_NONE, NULL, CLI_OPTION_HALF, "EXR with 16-bit numbers", NULL},
    {"tiled", 0, POPT_ARG_NONE, NULL, CLI_OPTION_TILED, "EXR in tiles of 64 x 64 instead of scanlines", NULL},
    {"png", 0, POPT_ARG_NONE, NULL, CLI_OPTION_PREVIEW, "write an 8-bit preview beside each EXR", NULL},
    {"exposure", 0, POPT_ARG_STRING, NULL, CLI_OPTION_EXPOSURE,
     "factor on the radiance in previews (default: chosen for each, and stated)", "X"},
    {"false-colour", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FALSE_COLOUR,
     "write the irradiance in colours beside each EXR, from 0 to TOP W/m2, or auto: chosen for each", "TOP"},
    {"compare", 0, POPT_ARG_STRING, NULL, CLI_OPTION_COMPARE,
     "compare each picture with an EXR: say RMSE, relative MSE and PSNR, write the difference beside it. The "
     "size, unless given, is that of REF",
     "REF.exr"},
    POPT_TABLEEND};

static bool take_crop(const char *text, int crop[4])
{
    int end = 0;
    bool plain = text[0] && strlen(text) < 32 && !text[strspn(text, "0123456789,")];
    if (!plain || sscanf(text, "%d,%d,%d,%d%n", &crop[0], &crop[1], &crop[2], &crop[3], &end) != 4 ||
        text[end] || crop[0] >= crop[2] || crop[1] >= crop[3]) {
        cli_complain("--crop '%s': expected X0,Y0,X1,Y1 in pixels from 0 with X0 < X1 and Y0 < Y1", text);
        return false;
    }
    return true;
}

static bool take_filter(const char *text, hpr_filter *filter)
{
    *filter = !strcmp(text, "gaussian") ? HPR_FILTER_GAUSSIAN : HPR_FILTER_BOX;
    if (*filter == HPR_FILTER_GAUSSIAN || !strcmp(text, "box"))
        return true;
    cli_complain("--filter '%s': expected box or gaussian", text);
    return false;
}

static bool take_layers(const char *text, uint32_t *layers)
{
    *layers = 0;
    for (const char *at = text;; at++) {
        size_t length = strcspn(at, ",");
        hpr_layer layer = hpr_layer_find(at, length);
        if (layer == HPR_LAYER_COUNT) {
            cli_complain(
                "--aov '%s': '%.*s' is none of irradiance, direct, indirect, emission, albedo, N, P, Z, "
                "degree, error, patchId, elementId",
                text, (int)length, at);
            return false;
        }
        *layers |= UINT32_C(1) << layer;
        at += length;
        if (!*at)
            return true;
    }
}

static bool take_frames(const char *text, int *first, int *count)
{
    int last = 0, end = 0;
    bool plain = isdigit((unsigned char)text[0]) && strlen(text) < 20 && !text[strspn(text, "0123456789-")];
    bool good = plain && sscanf(text, "%d-%d%n", first, &last, &end) == 2 && !text[end];
    if (!good) {
        good = plain && sscanf(text, "%d%n", first, &end) == 1 && !text[end];
        last = *first;
    }
    if (!good || *first < 0 || last < *first || last >= MAX_ORBIT) {
        cli_complain("--frames '%s': expected a number from 0, or two such as 10-19", text);
        return false;
    }
    *count = last - *first + 1;
    return true;
}

static bool take_centre(const char *text, hpr_job_render_options *settings)
{
    const char *rest = text;
    bool good = text[0] && !text[strspn(text, "0123456789.+-eE,")];
    for (int k = 0; k < 3 && good; k++) {
        char *end;
        settings->orbit_centre[k] = strtod(rest, &end);
        good = end != rest && isfinite(settings->orbit_centre[k]) && *end == (k < 2 ? ',' : '\0');
        rest = end + 1;
    }
    settings->orbit_centred = 1;
    if (!good)
        cli_complain("--orbit-centre '%s': expected X,Y,Z in metres, such as 0,1.5,0", text);
    return good;
}

static bool take_false_colour(const char *text, hpr_job_render_options *settings)
{
    settings->false_colour = 1;
    settings->false_colour_top = 0;
    return !strcmp(text, "auto") ||
           cli_positive("--false-colour", text, INFINITY, false, &settings->false_colour_top);
}

static int take_view_option(hpr_job_render_options *settings, int id, const char *value)
{
    hpr_view_options *view = &settings->view;
    switch (id) {
    case CLI_OPTION_CROP:
        return take_crop(value, view->crop);
    case CLI_OPTION_FILTER:
        return take_filter(value, &view->filter);
    case CLI_OPTION_FILTER_WIDTH:
        return cli_positive("--filter-width", value, MAX_FILTER_WIDTH, false, &view->filter_width);
    case CLI_OPTION_LAYERS:
        return take_layers(value, &view->layers);
    case CLI_OPTION_CAMERA_FILE:
        return cli_path("--camera-file", value, &settings->camera_file);
    case CLI_OPTION_ORBIT:
        return cli_integer("--orbit", value, 1, MAX_ORBIT, &settings->orbit);
    case CLI_OPTION_ORBIT_CENTRE:
        return take_centre(value, settings);
    case CLI_OPTION_FRAMES:
        return take_frames(value, &settings->first_frame, &settings->frame_count);
    default:
        return -1;
    }
}

int cli_take_render_option(hpr_job_render_options *settings, int id, const char *value)
{
    hpr_render_options *render = &settings->render;
    switch (id) {
    case CLI_OPTION_CAMERA:
        settings->camera = value;
        return true;
    case CLI_OPTION_SIZE:
        return cli_size("--size", value, &render->width, &render->height);
    case CLI_OPTION_SAMPLES:
        return cli_integer("--samples", value, 1, MAX_SAMPLES, &render->samples);
    case CLI_OPTION_HALF:
        return settings->half = 1;
    case CLI_OPTION_TILED:
        return settings->tiled = 1;
    case CLI_OPTION_PREVIEW:
        return settings->preview = 1;
    case CLI_OPTION_EXPOSURE:
        return cli_positive("--exposure", value, INFINITY, false, &settings->exposure);
    case CLI_OPTION_FALSE_COLOUR:
        return take_false_colour(value, settings);
    case CLI_OPTION_COMPARE:
        return cli_path("--compare", value, &settings->compare);
    default:
        return take_view_option(settings, id, value);
    }
}

bool cli_check_render_options(const hpr_job_render_options *settings)
{
    if (settings->exposure > 0 && !settings->preview) {
        cli_complain("--exposure '%g' is for previews only: add --png", settings->exposure);
        return false;
    }
    if (settings->orbit_centred && !settings->orbit) {
        cli_complain("--orbit-centre is for orbits only: add --orbit");
        return false;
    }
    return true;
}
