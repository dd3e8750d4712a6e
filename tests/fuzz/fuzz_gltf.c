/* Any bytes as a glTF file: refused with a message, or a scene whose patches can be made. ./dev fuzz gltf */
#include "reader.h"

#include "patch/patches.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    char path[64];
    hpr_scene *scene = NULL;
    hpr_patches *patches = NULL;
    hpr_context *context = fuzz_context();
    int file = fuzz_file(data, bytes, path);
    hpr_status status = hpr_scene_read(context, path, NULL, &scene);
    fuzz_expect((status == HPR_OK) == (scene != NULL), "a scene came with an error, or none without");
    fuzz_expect(status == HPR_OK || hpr_context_error(context)[0], "refused without a word");
    if (status == HPR_OK && scene->face_count <= 4096)
        status = hpr_patches_build(scene, &patches);
    hpr_patches_destroy(&patches);
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&context);
    close(file);
    return 0;
}
