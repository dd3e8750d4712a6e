#include "app/pictures.h"

#include "app/names.h"
#include "render/orbit.h"

#include <string.h>

hpr_status hpr_pictures_check(hpr_job *job, const char *input_path, const hpr_job_render_options *options)
{
    hpr_outputs_input(&job->outputs, input_path);
    if (options->camera_file)
        hpr_outputs_input(&job->outputs, options->camera_file);
    hpr_status status = HPR_OK;
    if (options->pattern)
        status = hpr_name_check(job->context, options->pattern);
    if (status == HPR_OK && options->compare)
        status = hpr_name_check(job->context, options->compare);
    if (status == HPR_OK && options->report_path)
        status = hpr_outputs_claim(&job->outputs, options->report_path);
    return status;
}

void hpr_pictures_release(hpr_context *ctx, hpr_pictures *list)
{
    hpr_camera_labels_release(ctx, list->camera_count, &list->label);
    for (size_t i = 0; list->files && i < list->count; i++) {
        hpr_release(ctx, list->files[i].exr);
        hpr_release(ctx, list->files[i].png);
        hpr_release(ctx, list->files[i].false_colour);
        hpr_release(ctx, list->files[i].reference);
        hpr_release(ctx, list->files[i].difference);
    }
    hpr_release(ctx, list->files);
    hpr_release(ctx, list->chosen);
    hpr_scene_destroy(&list->camera_file);
    *list = (hpr_pictures){0};
}

/* Names the cameras and chooses among them. A scene without camera will get one, without name. */
static hpr_status choose_cameras(hpr_context *ctx, size_t count, const hpr_camera *cameras,
                                 const char *wanted, hpr_pictures *list)
{
    const char **name = NULL;
    size_t first = 0;
    list->camera_count = count ? count : 1;
    hpr_status status = hpr_allocate_into(ctx, &name, list->camera_count, sizeof *name, "camera names");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        name[i] = cameras[i].name;
    status = hpr_camera_labels(ctx, list->camera_count, name, &list->label);
    if (status != HPR_OK)
        goto cleanup;
    bool all = !wanted || !strcmp(wanted, "all");
    if (!all)
        status = hpr_camera_find(ctx, list->camera_count, name, list->label, wanted, &first);
    if (status != HPR_OK)
        goto cleanup;
    size_t chosen = all ? list->camera_count : 1;
    status = hpr_allocate_into(ctx, &list->chosen, chosen, sizeof *list->chosen, "a list of cameras");
    if (status != HPR_OK)
        goto cleanup;
    list->chosen_count = chosen;
    for (size_t i = 0; i < chosen; i++)
        list->chosen[i] = first + i;
cleanup:
    hpr_release(ctx, name);
    return status;
}

/* Which of all pictures are made. */
static hpr_status choose_frames(hpr_context *ctx, const hpr_job_render_options *options, hpr_pictures *list)
{
    if (options->orbit < 0 || options->first_frame < 0 || options->frame_count < 0)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "%d pictures around the scene, %d from number %d on: none may be negative",
                        options->orbit, options->frame_count, options->first_frame);
    if (options->orbit && list->chosen_count > 1)
        return hpr_fail(
            ctx, HPR_ERR_ARG,
            "an orbit begins at one camera: choose one of the %zu with --camera ('%s' is the first)",
            list->chosen_count, list->label[0]);
    size_t all = options->orbit ? (size_t)options->orbit : list->chosen_count;
    list->first = (size_t)options->first_frame;
    list->count =
        options->frame_count ? (size_t)options->frame_count : all - (list->first < all ? list->first : 0);
    if (list->first >= all || list->count > all - list->first)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "pictures %zu to %zu are wanted (--frames); they are numbered 0 to %zu", list->first,
                        list->first + list->count - 1, all - 1);
    return HPR_OK;
}

/* The pattern in force, owned by the caller: the given or the default one, told apart if needed. */
static hpr_status choose_pattern(hpr_context *ctx, const hpr_job_render_options *options,
                                 const hpr_picture_source *source, const hpr_pictures *list, char **pattern)
{
    const char *given = options->pattern;
    const char *part = options->orbit ? "_{frame:04}" : "_{camera}";
    bool several = options->orbit ? options->orbit > 1 : list->chosen_count > 1;
    *pattern = given ? hpr_duplicate_text(ctx, given) : hpr_name_default(ctx, source->path, source->tail);
    if (*pattern && several && (!given || (source->insert_camera && !hpr_name_varies(given)))) {
        char *varied = hpr_name_insert(ctx, *pattern, part);
        hpr_release(ctx, *pattern);
        *pattern = varied;
    }
    if (!*pattern)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    if (list->count > 1 && !source->insert_camera && given && !hpr_name_varies(given))
        return hpr_fail(ctx, HPR_ERR_ARG,
                        options->orbit ? "output name '%s' is one for %zu pictures; put {frame:04} into it"
                                       : "output name '%s' is one for %zu cameras; put {camera} into it or "
                                         "choose a camera (--camera)",
                        given, list->count);
    return HPR_OK;
}

/* Claims the name beside the picture that ends in `tail`; caller releases *path. */
static hpr_status name_beside(hpr_job *job, const char *picture, const char *tail, char **path)
{
    *path = hpr_name_beside(job->context, picture, tail);
    if (!*path)
        return hpr_fail(job->context, HPR_ERR_MEMORY, "out of memory for a file name");
    return hpr_outputs_claim(&job->outputs, *path);
}

static hpr_status name_pictures(hpr_job *job, const char *pattern, hpr_pictures *list)
{
    hpr_context *ctx = job->context;
    const hpr_job_render_options *options = list->options;
    hpr_status status = hpr_allocate_into(ctx, &list->files, list->count, sizeof *list->files, "file names");
    for (size_t i = 0; i < list->count && status == HPR_OK; i++) {
        const char *label = list->label[hpr_pictures_camera(list, i)];
        hpr_picture_files *files = list->files + i;
        status = hpr_name_expand(ctx, pattern, label, list->first + i, &files->exr);
        if (status == HPR_OK)
            status = hpr_outputs_claim(&job->outputs, files->exr);
        if (status == HPR_OK && options->preview)
            status = name_beside(job, files->exr, ".png", &files->png);
        if (status == HPR_OK && options->false_colour)
            status = name_beside(job, files->exr, "_irradiance.png", &files->false_colour);
        if (status == HPR_OK && options->compare)
            status = name_beside(job, files->exr, "_difference.exr", &files->difference);
        if (status == HPR_OK && options->compare)
            status = hpr_name_expand(ctx, options->compare, label, list->first + i, &files->reference);
    }
    for (size_t i = 0; i < list->count && options->compare && status == HPR_OK; i++)
        status = hpr_outputs_spare(&job->outputs, list->files[i].reference);
    return status;
}

hpr_status hpr_pictures_plan(hpr_job *job, const hpr_job_render_options *options,
                             const hpr_picture_source *source, hpr_pictures *list)
{
    char *pattern = NULL;
    hpr_context *ctx = job->context;
    size_t cameras = source->camera_count;
    const hpr_camera *camera = source->camera;
    *list = (hpr_pictures){.options = options};
    hpr_status status = HPR_OK;
    if (options->camera_file) {
        status = hpr_job_enter(job, HPR_JOB_READ);
        if (status == HPR_OK)
            status = hpr_scene_read_cameras(ctx, options->camera_file, NULL, &list->camera_file);
        if (status == HPR_OK && list->camera_file->camera_count == 0)
            status = hpr_fail(ctx, HPR_ERR_FORMAT, "%s: it has no camera", options->camera_file);
        if (status != HPR_OK)
            return status;
        cameras = list->camera_file->camera_count;
        camera = list->camera_file->camera;
    }
    status = hpr_job_enter(job, HPR_JOB_CHECK);
    if (status == HPR_OK)
        status = choose_cameras(ctx, cameras, camera, options->camera, list);
    if (status == HPR_OK)
        status = choose_frames(ctx, options, list);
    if (status == HPR_OK)
        status = choose_pattern(ctx, options, source, list, &pattern);
    if (status == HPR_OK)
        status = name_pictures(job, pattern, list);
    hpr_release(ctx, pattern);
    return status;
}

size_t hpr_pictures_camera(const hpr_pictures *list, size_t i)
{
    return list->chosen[list->options->orbit ? 0 : list->first + i];
}

hpr_camera hpr_pictures_view(const hpr_pictures *list, size_t i, const hpr_camera *own,
                             const double centre[3])
{
    const hpr_job_render_options *options = list->options;
    const hpr_camera *cameras = list->camera_file ? list->camera_file->camera : own;
    const hpr_camera *camera = cameras + hpr_pictures_camera(list, i);
    if (!options->orbit)
        return *camera;
    return hpr_camera_orbit(camera, options->orbit_centred ? options->orbit_centre : centre, list->first + i,
                            (size_t)options->orbit);
}
