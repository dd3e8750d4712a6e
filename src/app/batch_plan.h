/* What a batch makes: solutions and groups of pictures, each file with its name and its key. */
#ifndef HPR_APP_BATCH_PLAN_H
#define HPR_APP_BATCH_PLAN_H

#include "app/batch_spec.h"
#include "app/pictures.h"
#include "io/sha256.h"

/* One scene at one setting. */
typedef struct hpr_batch_solution {
    const hpr_batch_scene *scene;
    const hpr_batch_setting *setting;
    char *scene_path, *path;   /* of the scene and of its solution */
    char key[HPR_SHA256_TEXT]; /* of program, scene and setting */
    char *trouble;             /* why there will be none; NULL: none known */
} hpr_batch_solution;

/* The pictures of one entry of "cameras" from one solution. */
typedef struct hpr_batch_group {
    size_t solution;
    const hpr_batch_camera *camera;
    char *pattern, *camera_file; /* with folders; {camera} and {frame} are still in the pattern */
    hpr_job_render_options options;
    hpr_pictures pictures;
    char key[HPR_SHA256_TEXT]; /* of the solution and the camera's entry; pictures add their number */
} hpr_batch_group;

typedef struct hpr_batch_plan {
    hpr_context *context;
    const hpr_batch_spec *spec;
    char *folder;
    size_t solution_count, group_count;
    hpr_batch_solution *solution; /* [solution_count] */
    hpr_batch_group *group;       /* [group_count] those of a solution follow each other */
} hpr_batch_plan;

/*
 * Makes the plan; of files it reads scenes and camera files only. A scene that cannot be read is the trouble
 * of its solutions, not of the plan. Errors: HPR_ERR_ARG (a name with unknown placeholders, or one for
 * several pictures), HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Release it in any case, before the spec.
 */
hpr_status hpr_batch_plan_make(hpr_context *ctx, const hpr_batch_spec *spec, hpr_batch_plan *plan);
void hpr_batch_plan_release(hpr_batch_plan *plan);

/* The key of picture i of a group. */
void hpr_batch_picture_key(const hpr_batch_group *group, size_t i, char key[HPR_SHA256_TEXT]);

/* The files of picture i: up to HPR_BATCH_FILES, [0] is the EXR. Returns their number. */
enum { HPR_BATCH_FILES = 3 };
size_t hpr_batch_picture_files(const hpr_batch_group *group, size_t i, const char *file[HPR_BATCH_FILES]);

#endif
