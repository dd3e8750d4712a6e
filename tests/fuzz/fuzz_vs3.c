/* Any bytes as a .vs3 file: refused with a message, or a model of finite polygons. ./dev fuzz vs3 */
#include "reader.h"

#include "io/vs3_read.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    char path[64];
    hpr_model *model = NULL;
    hpr_context *context = fuzz_context();
    int file = fuzz_file(data, bytes, path);
    hpr_status status = hpr_vs3_read(context, path, &model);
    fuzz_expect((status == HPR_OK) == (model != NULL), "a model came with an error, or none without");
    fuzz_expect(status == HPR_OK || hpr_context_error(context)[0], "refused without a word");
    for (size_t i = 0; model && i < model->count; i++) {
        const hpr_surface *surface = model->surface + i;
        fuzz_expect(surface->corner_count == 3 || surface->corner_count == 4, "a surface of other corners");
        fuzz_expect(isfinite(surface->area_m2) && surface->area_m2 >= 0, "a surface without area");
        fuzz_expect(surface->base == HPR_NONE || surface->base < i, "a base that comes later");
    }
    hpr_model_destroy(&model);
    hpr_context_destroy(&context);
    close(file);
    return 0;
}
