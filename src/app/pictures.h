/* The pictures of one job: which cameras, under which names, and how they are written. */
#ifndef HPR_APP_PICTURES_H
#define HPR_APP_PICTURES_H

#include "app/job.h"
#include "scene/scene.h"

typedef struct hpr_pictures {
    size_t camera_count;
    char **label; /* [camera_count] as {camera} names them */
    size_t count;
    size_t *camera;  /* [count] index of the camera */
    char **exr_path; /* [count] */
    char **png_path; /* [count], entries NULL without preview */
} hpr_pictures;

/* Where the cameras come from and how names are made of it. */
typedef struct hpr_picture_source {
    const char *path; /* of the job's input */
    const char *tail; /* ends the default name: ".exr" */
    /* If one name is given for several cameras: true: {camera} is put into it; false: it is refused. */
    bool insert_camera;
    size_t camera_count;
    const hpr_camera *camera; /* [camera_count] */
} hpr_picture_source;

/* Declares the job's input and says what can be said of its outputs before the cameras are known. The pattern
 * and the report's path may be NULL. Errors: HPR_ERR_ARG, HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_pictures_check(hpr_job *job, const char *input_path, const char *pattern,
                              const char *report_path);

/*
 * Everything about the pictures that can be refused before long work: chooses the cameras, names the files,
 * claims them. A source without camera counts as having one, without name. Errors: those of hpr_job_render's
 * step CHECK. Released in any case.
 */
hpr_status hpr_pictures_plan(hpr_job *job, const hpr_job_render_options *options,
                             const hpr_picture_source *source, hpr_pictures *pictures);
void hpr_pictures_release(hpr_context *ctx, hpr_pictures *pictures);

/* Writes picture i, and its preview if it has one. labels->camera may be NULL or "": then it is the one of
 * {camera}. */
hpr_status hpr_pictures_write(hpr_job *job, const hpr_pictures *pictures, size_t i, const hpr_image *image,
                              const hpr_image_labels *labels, double exposure);

#endif
