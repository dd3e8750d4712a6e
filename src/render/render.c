#include "render/renderer.h"

enum { DEFAULT_SAMPLES = 4 };

void hpr_render_options_init(hpr_render_options *options)
{
    *options = (hpr_render_options){.samples = DEFAULT_SAMPLES};
}

void hpr_view_options_init(hpr_view_options *view)
{
    *view = (hpr_view_options){.filter = HPR_FILTER_BOX};
}

hpr_status hpr_solution_render(hpr_context *ctx, const hpr_solution *solution, size_t camera,
                               const hpr_render_options *options, hpr_image *image)
{
    return hpr_solution_view(ctx, solution, camera, options, NULL, image);
}

hpr_status hpr_solution_view(hpr_context *ctx, const hpr_solution *solution, size_t camera,
                             const hpr_render_options *options, const hpr_view_options *view,
                             hpr_image *image)
{
    hpr_context_clear_error(ctx);
    *image = (hpr_image){0};
    if (camera >= solution->camera_count)
        return hpr_fail(ctx, HPR_ERR_ARG, "camera %zu does not exist: the solution has %zu", camera,
                        solution->camera_count);
    hpr_renderer *renderer = NULL;
    hpr_status status = hpr_renderer_create(ctx, solution, &renderer);
    if (status == HPR_OK)
        status = hpr_renderer_render(renderer, &solution->camera[camera], options, view, image);
    hpr_renderer_destroy(&renderer);
    return status;
}
