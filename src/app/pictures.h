/* The pictures of one job: seen by which cameras, under which names, and how they are written. */
#ifndef HPR_APP_PICTURES_H
#define HPR_APP_PICTURES_H

#include "app/job.h"
#include "scene/scene.h"

/* The files of one picture. */
typedef struct hpr_picture_files {
    char *exr;
    char *png, *false_colour;     /* NULL: none */
    char *reference, *difference; /* NULL: it is not compared */
} hpr_picture_files;

typedef struct hpr_pictures {
    const hpr_job_render_options *options; /* borrowed */
    hpr_scene *camera_file;                /* NULL: the cameras are the input's */
    size_t camera_count;
    char **label; /* [camera_count] as {camera} names them */
    size_t chosen_count;
    size_t *chosen;           /* [chosen_count] indices of cameras */
    size_t first, count;      /* the pictures' numbers are first ... first + count - 1 */
    hpr_picture_files *files; /* [count] */
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

/* Declares the job's inputs and says what can be said of its outputs before the cameras are known. Errors:
 * HPR_ERR_ARG, HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_pictures_check(hpr_job *job, const char *input_path, const hpr_job_render_options *options);

/*
 * Everything about the pictures that can be refused before long work: reads the camera file, chooses the
 * cameras, names the files, claims them. A source without camera counts as having one, without name. Errors:
 * those of hpr_job_render's steps CHECK and READ. Released in any case. `options` is borrowed until then.
 */
hpr_status hpr_pictures_plan(hpr_job *job, const hpr_job_render_options *options,
                             const hpr_picture_source *source, hpr_pictures *pictures);
void hpr_pictures_release(hpr_context *ctx, hpr_pictures *pictures);

/* Index of the camera of picture i < count, before it is turned. */
size_t hpr_pictures_camera(const hpr_pictures *pictures, size_t i);

/* The camera of picture i, of the camera file or else of `own` [camera_count], turned if it is an orbit;
 * `centre` is that of the scene. The name is borrowed. */
hpr_camera hpr_pictures_view(const hpr_pictures *pictures, size_t i, const hpr_camera *own,
                             const double centre[3]);

/* Reads what picture i is compared with; a zero image if nothing. Errors: those of hpr_image_read_exr, in the
 * step READ. Fini the image in any case. */
hpr_status hpr_pictures_reference(hpr_job *job, const hpr_pictures *pictures, size_t i,
                                  const hpr_image_labels *labels, size_t channel_count, hpr_image *reference);

/* Writes picture i and what goes with it: preview, false colours, difference (if `reference` has pixels).
 * labels->camera may be NULL or "": then it is the one of {camera}. */
hpr_status hpr_pictures_write(hpr_job *job, const hpr_pictures *pictures, size_t i, const hpr_image *image,
                              const hpr_image *reference, const hpr_image_labels *labels);

#endif
