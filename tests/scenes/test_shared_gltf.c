/*
 * Reads every .gltf and .glb under shared/gltf. Those of real/ must load; those of broken/ must end as the
 * table says, and a file that the table does not know is a failure. Skipped (77) without that folder.
 */
#include "scene/scene.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct expectation {
    const char *path; /* below shared/gltf */
    hpr_status status;
    const char *message;
} expectation;

static const expectation expectations[] = {
    /* Loads: only its normals are wrong (zero), and hprad takes normals from the corners. */
    {"broken/BoxBadNormals-glTF-Binary/BoxBadNormals.glb", HPR_OK, ""},
    /* Loads: glTF allows a scene without nodes; it is empty. */
    {"broken/TestNoRootNode/SceneWithoutNodes.gltf", HPR_OK, ""},
    {"broken/TestNoRootNode/NoScene.gltf", HPR_ERR_FORMAT,
     "scene must be an index into scenes (there are 0)"},
    {"broken/SchemaFailures/sceneWrongType.gltf", HPR_ERR_FORMAT, "not \"hello\""},
    {"broken/IncorrectVertexArrays/Cube.gltf", HPR_ERR_FORMAT,
     "bufferView 2 ends 422 bytes past its buffer 0"},
    {"broken/IndexOutOfRange/IndexOutOfRange.gltf", HPR_ERR_FORMAT, "is 255, but there are 24 vertices"},
    {"broken/IndexOutOfRange/AllIndicesOutOfRange.gltf", HPR_ERR_FORMAT,
     "is 65535, but there are 24 vertices"},
    {"broken/issue_3269/texcoord_crash.gltf", HPR_ERR_FORMAT,
     "mesh 0 'TopRightMesh', primitive 0 has no TEXCOORD_0"},
    {"broken/wrongTypes/badNumber.gltf", HPR_ERR_FORMAT, "material 0 'Texture': normalTexture"},
    {"broken/wrongTypes/badExtension.gltf", HPR_ERR_FORMAT, "KHR_texture_transform must be an object"},
    {"broken/wrongTypes/badObject.gltf", HPR_ERR_FORMAT, "pbrMetallicRoughness must be an object"},
    {"broken/wrongTypes/badUint.gltf", HPR_ERR_FORMAT,
     "baseColorTexture.index must be an index into textures"},
    {"broken/wrongTypes/badArray.gltf", HPR_ERR_FORMAT, "mesh 0 'Mesh': primitives must be an array"},
    {"broken/wrongTypes/badString.gltf", HPR_ERR_FORMAT, "scene 0: name must be a string, not 42"},
    {"broken/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", HPR_ERR_FORMAT,
     "vertex 0 has the coordinate -inf"},
    {"broken/draco-unsupported/2CylinderEngine.gltf", HPR_ERR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"broken/RecursiveNodes/RecursiveNodes.gltf", HPR_ERR_FORMAT, "node 0 is among its own ancestors"},
    {"broken/MissingBin/BoxTextured.gltf", HPR_ERR_IO, "BoxTextured0.bin' cannot be read"},
    {"real/DenseSphere.glb", HPR_ERR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    /* Its many-cubes.bin is not among the shared files. */
    {"real/many-cubes.gltf", HPR_ERR_IO, "many-cubes.bin' cannot be read"},
};

static size_t passed, failed;

static void check_file(const char *root, const char *below)
{
    enum { COUNT = sizeof expectations / sizeof *expectations };
    const expectation loads = {below, HPR_OK, ""}, *expected = NULL;
    for (size_t i = 0; i < COUNT; i++) {
        if (!strcmp(expectations[i].path, below))
            expected = &expectations[i];
    }
    if (!expected && !strncmp(below, "real/", 5))
        expected = &loads;
    char path[8192];
    snprintf(path, sizeof path, "%s/%s", root, below);
    hpr_context *ctx;
    hpr_scene *scene = NULL;
    if (hpr_context_create(NULL, &ctx) != HPR_OK)
        exit(1);
    hpr_status status = hpr_scene_read(ctx, path, NULL, &scene);
    const char *message = hpr_context_error(ctx), *name = strrchr(below, '/') + 1;
    bool good = expected && status == expected->status && strstr(message, expected->message) &&
                (status == HPR_OK || strstr(message, name));
    printf("%s %s: %s%s\n", good ? "ok    " : "FAILED", below, hpr_status_string(status),
           expected ? "" : " (not in the table)");
    if (!good)
        printf("    %s\n", message);
    passed += good;
    failed += !good;
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&ctx);
}

static void walk(const char *root, const char *below)
{
    char path[8192], inner[4096];
    snprintf(path, sizeof path, "%s/%s", root, below);
    DIR *directory = opendir(path);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        if (entry->d_name[0] == '.')
            continue;
        const char *dot = strrchr(entry->d_name, '.');
        struct stat info;
        snprintf(path, sizeof path, "%s/%s/%s", root, below, entry->d_name);
        snprintf(inner, sizeof inner, "%s/%s", below, entry->d_name);
        if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
            walk(root, inner);
        else if (dot && (!strcmp(dot, ".gltf") || !strcmp(dot, ".glb")))
            check_file(root, inner);
    }
    if (directory)
        closedir(directory);
}

int main(void)
{
    const char *shared = getenv("HPRAD_SHARED");
    char root[2048];
    snprintf(root, sizeof root, "%s/gltf", shared ? shared : HPRAD_SHARED);
    walk(root, "real");
    walk(root, "broken");
    printf("%zu passed, %zu failed\n", passed, failed);
    return failed ? 1 : passed ? 0 : 77;
}
