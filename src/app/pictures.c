#include "app/pictures.h"

#include "app/names.h"

#include <string.h>

hpr_status hpr_pictures_check(hpr_job *job, const char *input_path, const char *pattern,
                              const char *report_path)
{
    hpr_outputs_input(&job->outputs, input_path);
    hpr_status status = HPR_OK;
    if (pattern)
        status = hpr_name_check(job->context, pattern);
    if (status == HPR_OK && report_path)
        status = hpr_outputs_claim(&job->outputs, report_path);
    return status;
}

static void release_texts(hpr_context *ctx, size_t count, char **text)
{
    for (size_t i = 0; text && i < count; i++)
        hpr_release(ctx, text[i]);
    hpr_release(ctx, text);
}

void hpr_pictures_release(hpr_context *ctx, hpr_pictures *list)
{
    hpr_camera_labels_release(ctx, list->camera_count, &list->label);
    release_texts(ctx, list->count, list->exr_path);
    release_texts(ctx, list->count, list->png_path);
    hpr_release(ctx, list->camera);
    *list = (hpr_pictures){0};
}

/* Names the cameras and chooses among them. A scene without camera will get one, without name. */
static hpr_status choose_cameras(hpr_context *ctx, size_t count, const hpr_camera *cameras,
                                 const char *wanted, hpr_pictures *list)
{
    const char **name = NULL;
    size_t first = 0;
    list->camera_count = count ? count : 1;
    list->count = 0;
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
    status = hpr_allocate_into(ctx, &list->camera, chosen, sizeof *list->camera, "a list of cameras");
    if (status != HPR_OK)
        goto cleanup;
    list->count = chosen;
    for (size_t i = 0; i < chosen; i++)
        list->camera[i] = first + i;
cleanup:
    hpr_release(ctx, name);
    return status;
}

/* The pattern in force, owned by the caller: the given or the default one, told apart by camera if needed. */
static hpr_status choose_pattern(hpr_context *ctx, const hpr_job_render_options *options,
                                 const hpr_picture_source *source, const hpr_pictures *list, char **pattern)
{
    const char *given = options->pattern;
    *pattern = given ? hpr_duplicate_text(ctx, given) : hpr_name_default(ctx, source->path, source->tail);
    if (*pattern && list->count > 1 && (!given || (source->insert_camera && !hpr_name_varies(given)))) {
        char *varied = hpr_name_insert_camera(ctx, *pattern);
        hpr_release(ctx, *pattern);
        *pattern = varied;
    }
    if (!*pattern)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    if (list->count > 1 && given && !source->insert_camera && !hpr_name_varies(given))
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "output name '%s' is one for %zu cameras; put {camera} into it or choose a camera "
                        "(--camera)",
                        given, list->count);
    return HPR_OK;
}

static hpr_status name_pictures(hpr_job *job, const char *pattern, bool preview, hpr_pictures *list)
{
    hpr_context *ctx = job->context;
    hpr_status status =
        hpr_allocate_into(ctx, &list->exr_path, list->count, sizeof *list->exr_path, "file names");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &list->png_path, list->count, sizeof *list->png_path, "file names");
    for (size_t i = 0; i < list->count && status == HPR_OK; i++) {
        const char *label = list->label[list->camera[i]];
        status = hpr_name_expand(ctx, pattern, label, i, &list->exr_path[i]);
        if (status == HPR_OK)
            status = hpr_outputs_claim(&job->outputs, list->exr_path[i]);
        if (status != HPR_OK || !preview)
            continue;
        list->png_path[i] = hpr_name_beside(ctx, list->exr_path[i], ".png");
        if (!list->png_path[i])
            return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
        status = hpr_outputs_claim(&job->outputs, list->png_path[i]);
    }
    return status;
}

hpr_status hpr_pictures_plan(hpr_job *job, const hpr_job_render_options *options,
                             const hpr_picture_source *source, hpr_pictures *list)
{
    char *pattern = NULL;
    hpr_status status = hpr_job_enter(job, HPR_JOB_CHECK);
    if (status == HPR_OK)
        status = choose_cameras(job->context, source->camera_count, source->camera, options->camera, list);
    if (status == HPR_OK)
        status = choose_pattern(job->context, options, source, list, &pattern);
    if (status == HPR_OK)
        status = name_pictures(job, pattern, options->preview, list);
    hpr_release(job->context, pattern);
    return status;
}

static hpr_status write_exr(hpr_job *job, const char *path, const hpr_image *image,
                            const hpr_image_labels *labels, hpr_job_file *file)
{
    hpr_image_labels all = *labels;
    if (!all.camera || !all.camera[0])
        all.camera = file->camera;
    file->kind = HPR_JOB_FILE_EXR;
    file->path = path;
    hpr_status status = hpr_image_write_exr(job->context, image, &all, path);
    if (status != HPR_OK)
        return status;
    job->result->picture_count++;
    hpr_job_wrote(job, file);
    return HPR_OK;
}

static hpr_status write_png(hpr_job *job, double exposure, const char *path, const hpr_image *image,
                            hpr_job_file *file)
{
    file->kind = HPR_JOB_FILE_PNG;
    file->path = path;
    hpr_status status = hpr_image_write_png(job->context, image, exposure, path, &file->exposure);
    if (status == HPR_OK)
        hpr_job_wrote(job, file);
    return status;
}

hpr_status hpr_pictures_write(hpr_job *job, const hpr_pictures *list, size_t i, const hpr_image *image,
                              const hpr_image_labels *labels, double exposure)
{
    hpr_job_file file = {
        .camera = list->label[list->camera[i]], .width = image->width, .height = image->height};
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "write");
    status = write_exr(job, list->exr_path[i], image, labels, &file);
    if (status == HPR_OK && list->png_path[i])
        status = write_png(job, exposure, list->png_path[i], image, &file);
    hpr_stage_end(job->context);
    return status;
}
