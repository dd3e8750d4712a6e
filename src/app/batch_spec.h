/*
 * What a batch file asks for. The file is a JSON object; the README describes its keys for users:
 *   folder    where everything goes, relative to the batch file; default "."
 *   pictures  names of the pictures within it; {scene}, {setting}, {camera}, {frame} and {frame:04} are
 *             replaced; default "{scene}_{setting}_{camera}.exr"
 *   scenes    [texts, or {name, file, scene_index, max_reflectance, metallic, environment}]
 *   settings  [{name, order, subdivide, feet, grade, link_tol, block_tol, solver, max_sweeps, direct}];
 *             default one, "default", of default options
 *   cameras   [{camera, camera_file, orbit, orbit_centre, frames, size, crop, samples, filter, filter_width,
 *             aov, half, tiled, png, exposure, false_colour, pictures}]; default every camera of the scene
 * Values are as those of the command's options; sizes, windows, centres and lists are arrays, flags true or
 * false. An unknown key is an error, and so is a key given twice.
 */
#ifndef HPR_APP_BATCH_SPEC_H
#define HPR_APP_BATCH_SPEC_H

#include <cjson/cJSON.h>
#include <hprad/job.h>

enum { HPR_BATCH_MAX_CHANNELS = 64 };

typedef struct hpr_batch_scene {
    const char *name; /* of the file without folders and extension unless given */
    const char *file; /* as in the batch file */
    hpr_read_options read;
    size_t environment_count;
    double environment[HPR_BATCH_MAX_CHANNELS];
    const cJSON *item; /* the text that stands for it in keys */
} hpr_batch_scene;

typedef struct hpr_batch_setting {
    const char *name;
    hpr_solve_options solve;
    const cJSON *item;
} hpr_batch_setting;

typedef struct hpr_batch_camera {
    const char *pictures; /* pattern; NULL: the batch's */
    hpr_job_render_options options;
    const cJSON *item;
} hpr_batch_camera;

typedef struct hpr_batch_spec {
    hpr_context *context;
    const char *path;
    char *text;
    cJSON *root;
    const char *folder, *pictures;
    size_t scene_count, setting_count, camera_count;
    hpr_batch_scene *scene;
    hpr_batch_setting *setting;
    hpr_batch_camera *camera;
    size_t made_count, made_capacity;
    char **made; /* names that are not in the file */
} hpr_batch_spec;

/* Errors: HPR_ERR_IO, HPR_ERR_FORMAT (the message begins with file, line and key), HPR_ERR_MEMORY. Release it
 * in any case; texts of it are valid until then. */
hpr_status hpr_batch_spec_read(hpr_context *ctx, const char *path, hpr_batch_spec *spec);
void hpr_batch_spec_release(hpr_batch_spec *spec);

#endif
