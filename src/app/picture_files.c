/* What is written of a picture, and what it is compared with. */
#include "app/pictures.h"

static hpr_status write_exr(hpr_job *job, const char *path, const hpr_image *image,
                            const hpr_image_labels *labels, hpr_job_file *file)
{
    file->kind = HPR_JOB_FILE_EXR;
    file->path = path;
    hpr_status status = hpr_image_write_exr(job->context, image, labels, path);
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
    file->exposure = 0;
    return status;
}

static hpr_status write_false_colour(hpr_job *job, double top, const char *path, const hpr_image *image,
                                     hpr_job_file *file)
{
    file->kind = HPR_JOB_FILE_FALSE_COLOUR;
    file->path = path;
    hpr_status status = hpr_image_write_false_colour(job->context, image, top, path, &file->top);
    if (status == HPR_OK)
        hpr_job_wrote(job, file);
    file->top = 0;
    return status;
}

static hpr_status write_difference(hpr_job *job, const hpr_picture_files *files, const hpr_image *image,
                                   const hpr_image *reference, const hpr_image_labels *labels,
                                   hpr_job_file *file)
{
    hpr_image image_of_it;
    hpr_difference difference;
    hpr_image_labels plain = *labels;
    plain.half = 0; /* small numbers are what matters here */
    file->kind = HPR_JOB_FILE_DIFFERENCE;
    file->path = files->difference;
    file->reference = files->reference;
    file->difference = &difference;
    hpr_status status = hpr_image_compare(job->context, image, reference, &difference, &image_of_it);
    if (status == HPR_OK)
        status = hpr_image_write_exr(job->context, &image_of_it, &plain, files->difference);
    if (status == HPR_OK)
        hpr_job_wrote(job, file);
    hpr_image_fini(job->context, &image_of_it);
    return status;
}

hpr_status hpr_pictures_reference(hpr_job *job, const hpr_pictures *list, size_t i,
                                  const hpr_image_labels *labels, size_t channel_count, hpr_image *reference)
{
    *reference = (hpr_image){0};
    if (!list->files[i].reference)
        return HPR_OK;
    hpr_status status = hpr_job_enter(job, HPR_JOB_READ);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "read");
    status = hpr_image_read_exr(job->context, list->files[i].reference, channel_count, labels->channel_name,
                                reference);
    hpr_stage_end(job->context);
    return status;
}

hpr_status hpr_pictures_write(hpr_job *job, const hpr_pictures *list, size_t i, const hpr_image *image,
                              const hpr_image *reference, const hpr_image_labels *labels)
{
    const hpr_job_render_options *options = list->options;
    const hpr_picture_files *files = list->files + i;
    hpr_job_file file = {
        .camera = list->label[hpr_pictures_camera(list, i)], .width = image->width, .height = image->height};
    hpr_image_labels all = *labels;
    if (!all.camera || !all.camera[0])
        all.camera = file.camera;
    all.half = options->half;
    all.tiled = options->tiled;
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "write");
    status = write_exr(job, files->exr, image, &all, &file);
    if (status == HPR_OK && files->png)
        status = write_png(job, options->exposure, files->png, image, &file);
    if (status == HPR_OK && files->false_colour)
        status = write_false_colour(job, options->false_colour_top, files->false_colour, image, &file);
    if (status == HPR_OK && reference && reference->radiance)
        status = write_difference(job, files, image, reference, &all, &file);
    hpr_stage_end(job->context);
    return status;
}
