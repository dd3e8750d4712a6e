/* A solution that is ready to be looked at: what all its views share is made once. */
#ifndef HPR_RENDER_RENDERER_H
#define HPR_RENDER_RENDERER_H

#include "solver/solution.h"

#include <hprad/render.h>

typedef struct hpr_renderer hpr_renderer;

/* Borrows the solution until destroyed. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_UNSUPPORTED. */
hpr_status hpr_renderer_create(hpr_context *ctx, const hpr_solution *solution, hpr_renderer **renderer);
void hpr_renderer_destroy(hpr_renderer **renderer);

/*
 * Makes the picture that `camera` sees. options and view may be NULL. The picture depends on nothing but
 * solution, camera, options and view: not on what was rendered before, nor on the number of threads. Errors:
 * those of hpr_solution_view. Fini with hpr_image_fini. One call at a time.
 */
hpr_status hpr_renderer_render(hpr_renderer *renderer, const hpr_camera *camera,
                               const hpr_render_options *options, const hpr_view_options *view,
                               hpr_image *image);

#endif
