/*
 * The solution as a .glb. To a viewer it is one unlit mesh with vertex colours, plus the scene's cameras. To
 * hprad the root's extension HPRAD_radiosity says everything, exactly; the mesh is not read back.
 *
 * HPRAD_radiosity, version 1. Lengths in metres, light in SI units per channel; little-endian numbers. An
 * array is an object {"bufferView", "componentType": "uint8" | "uint32" | "uint64" | "float64", "components":
 * numbers per item, "count": items}; an empty one has no buffer view. 4294967295 (2^32 - 1) means "none".
 * Numbers in the JSON that are not finite are the texts "NaN", "Infinity", "-Infinity".
 *
 *   version     1; a reader refuses what is newer than itself
 *   scene       file name of the scene, without folders
 *   exposure    COLOR_0 = clamp(exposure * L, 0, 1), L = (exitance + reflectance * H) / pi in W/m2/sr
 *   channels    names, usually R, G, B (linear Rec. 709)
 *   patches     count, degenerateCount, duplicateCount (faces left out), weldDistance (m;
 *               corners nearer than this are one), and per patch, one patch being one
 *               side of a surface, x = origin + s edge1 + t edge2:
 *       shape         uint8: 0 parallelogram (0 <= s,t <= 1), 1 triangle (0 <= s,t and s+t <= 1), 2
 *                     quadrilateral; what those add is in solution_format.h
 *       side          uint8: 1 for the back of a doubleSided face
 *       twin          uint32: the patch on the other side, or none. Every patch blocks light from both sides
 *       node, primitive, material   uint32: where it comes from in the scene; material may be none
 *       origin, edge1, edge2, normal   3 float64; normal is along edge1 x edge2, of length 1
 *       area          float64
 *       reflectance, exitance   float64 per channel: rho (mean over the patch), M in W/m2
 *   elements    count, leafCount, and per node of the binary trees (roots first: node i is patch i):
 *       patch         uint32
 *       child         uint32: the first of two consecutive children, or none for a leaf
 *       axis          uint8: the parameter that the children halve (0: s, 1: t; parallelograms only). A
 *                     triangle (v0, v1, v2), m amid v1 and v2, has the children (m, v0, v1) and (m, v2, v0)
 *       degree        uint8: p, at most 16
 *       origin, edge1, edge2, area   the node's own frame
 *   solution    coefficientCount, and
 *       leaf              uint32 per leaf: its node; by patch, then first child first
 *       firstCoefficient  uint64 per leaf and one more: the leaf's first coefficient; it has (p+1)^2 on a
 *                         parallelogram, (p+1)(p+2)/2 on a triangle
 *       irradiance        float64 per coefficient and channel: H(x) = sum_k irradiance[k] T_k(x), T_k
 *                         orthonormal on the element (Legendre a-major, Dubiner by total degree): W/m2 * m
 *       error             float64 per leaf: estimated L2 error of H, W/m2 * m; NaN: unknown
 *   cameras     name, kind ("perspective" | "orthographic"), origin, right, up, backward, yfov (radians),
 *               aspectRatio (0: the picture's), xmag, ymag, znear, zfar
 *   summary     of the solve: options and counts
 *   energy      per channel in W: emitted, absorbed, lostOnBacks, escaped
 */
#include "io/glb.h"
#include "io/json_text.h"
#include "io/solution_column.h"
#include "io/solution_mesh.h"
#include "io/solution_paint.h"
#include "patch/paint.h"

#include <hprad/version.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static void add_vector(cJSON *object, const char *key, const double *value, size_t count, bool *ok)
{
    cJSON *array = hpr_json_array(object, key, ok);
    for (size_t i = 0; i < count; i++)
        hpr_json_exact(array, NULL, value[i], ok);
}

static void add_fields(cJSON *object, const void *structure, const hpr_field *fields, size_t count, bool *ok)
{
    for (size_t i = 0; i < count; i++) {
        const char *at = (const char *)structure + fields[i].offset;
        double value = 0;
        if (fields[i].kind == HPR_FIELD_DOUBLE)
            memcpy(&value, at, sizeof value);
        else if (fields[i].kind == HPR_FIELD_INT)
            value = *(const int *)(const void *)at;
        else
            value = (double)*(const size_t *)(const void *)at;
        hpr_json_exact(object, fields[i].key, value, ok);
    }
}

/* accessors: index of the one that is added */
static hpr_status add_accessor(hpr_glb_builder *glb, cJSON *accessors, const void *data, size_t count,
                               size_t components, int target)
{
    enum { FLOAT = 5126, UNSIGNED_INT = 5125 };
    size_t view;
    hpr_status status = hpr_glb_add_view(glb, data, count * components * 4, target, &view);
    if (status != HPR_OK)
        return status;
    bool *ok = &glb->ok;
    cJSON *accessor = hpr_json_object(accessors, NULL, ok);
    hpr_json_number(accessor, "bufferView", (double)view, ok);
    hpr_json_number(accessor, "componentType", target == HPR_GLB_INDICES ? UNSIGNED_INT : FLOAT, ok);
    hpr_json_number(accessor, "count", (double)count, ok);
    hpr_json_text(accessor, "type", components == 1 ? "SCALAR" : "VEC3", ok);
    return HPR_OK;
}

static void add_bounds(cJSON *accessor, const hpr_solution_mesh *mesh, bool *ok)
{
    double low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = (double)mesh->low[k];
        high[k] = (double)mesh->high[k];
    }
    add_vector(accessor, "min", low, 3, ok);
    add_vector(accessor, "max", high, 3, ok);
}

/* Unlit, and plain white for viewers that light it all the same. */
static void add_material(cJSON *root, bool *ok)
{
    cJSON *material = hpr_json_object(hpr_json_array(root, "materials", ok), NULL, ok);
    hpr_json_text(material, "name", "radiosity", ok);
    cJSON *pbr = hpr_json_object(material, "pbrMetallicRoughness", ok);
    hpr_json_number(pbr, "metallicFactor", 0, ok);
    hpr_json_number(pbr, "roughnessFactor", 1, ok);
    hpr_json_object(hpr_json_object(material, "extensions", ok), "KHR_materials_unlit", ok);
}

static hpr_status add_mesh(hpr_glb_builder *glb, const hpr_solution_mesh *mesh, cJSON *nodes, cJSON *scene)
{
    if (!mesh->vertex_count) /* glTF knows no empty mesh */
        return HPR_OK;
    bool *ok = &glb->ok;
    cJSON *accessors = hpr_json_array(glb->root, "accessors", ok);
    hpr_status status = add_accessor(glb, accessors, mesh->position, mesh->vertex_count, 3, HPR_GLB_VERTICES);
    if (status == HPR_OK)
        status = add_accessor(glb, accessors, mesh->colour, mesh->vertex_count, 3, HPR_GLB_VERTICES);
    if (status == HPR_OK)
        status = add_accessor(glb, accessors, mesh->index, mesh->index_count, 1, HPR_GLB_INDICES);
    if (status != HPR_OK)
        return status;
    add_bounds(cJSON_GetArrayItem(accessors, 0), mesh, ok);
    add_material(glb->root, ok);
    cJSON *gltf_mesh = hpr_json_object(hpr_json_array(glb->root, "meshes", ok), NULL, ok);
    cJSON *primitive = hpr_json_object(hpr_json_array(gltf_mesh, "primitives", ok), NULL, ok);
    cJSON *attributes = hpr_json_object(primitive, "attributes", ok);
    hpr_json_number(attributes, "POSITION", 0, ok);
    hpr_json_number(attributes, "COLOR_0", 1, ok);
    hpr_json_number(primitive, "indices", 2, ok);
    hpr_json_number(primitive, "material", 0, ok);
    cJSON *node = hpr_json_object(nodes, NULL, ok);
    hpr_json_text(node, "name", "radiosity", ok);
    hpr_json_number(node, "mesh", 0, ok);
    add_vector(node, "translation", mesh->centre, 3, ok);
    hpr_json_number(scene, NULL, 0, ok);
    return HPR_OK;
}

/* glTF wants 0 < znear < zfar; what a camera lacks there is filled in from the size of the scene. */
static void add_lens(cJSON *parent, const hpr_camera *camera, double radius, bool *ok)
{
    bool perspective = camera->kind == HPR_CAMERA_PERSPECTIVE;
    double size = radius > 0 ? radius : 1;
    double znear = isfinite(camera->znear) && camera->znear > 0 ? camera->znear
                   : perspective                                ? 1e-3 * size
                                                                : 0;
    bool closed = isfinite(camera->zfar) && camera->zfar > znear;
    hpr_json_text(parent, "type", perspective ? "perspective" : "orthographic", ok);
    cJSON *lens = hpr_json_object(parent, perspective ? "perspective" : "orthographic", ok);
    if (perspective) {
        if (camera->aspect > 0)
            hpr_json_number(lens, "aspectRatio", camera->aspect, ok);
        hpr_json_number(lens, "yfov", camera->yfov_rad, ok);
    } else {
        hpr_json_number(lens, "xmag", camera->xmag, ok);
        hpr_json_number(lens, "ymag", camera->ymag, ok);
    }
    hpr_json_number(lens, "znear", znear, ok);
    if (closed || !perspective)
        hpr_json_number(lens, "zfar", closed ? camera->zfar : znear + 1e3 * size, ok);
}

static void add_cameras(cJSON *root, const hpr_solution *solution, double radius, cJSON *nodes, cJSON *scene,
                        bool *ok)
{
    if (!solution->camera_count)
        return;
    cJSON *cameras = hpr_json_array(root, "cameras", ok);
    for (size_t i = 0; i < solution->camera_count; i++) {
        const hpr_camera *camera = solution->camera + i;
        cJSON *item = hpr_json_object(cameras, NULL, ok);
        if (camera->name[0])
            hpr_json_text(item, "name", camera->name, ok);
        add_lens(item, camera, radius, ok);
        double matrix[16] = {[15] = 1};
        for (int k = 0; k < 3; k++) {
            matrix[k] = camera->right[k];
            matrix[4 + k] = camera->up[k];
            matrix[8 + k] = camera->backward[k];
            matrix[12 + k] = camera->origin[k];
        }
        cJSON *node = hpr_json_object(nodes, NULL, ok);
        if (camera->name[0])
            hpr_json_text(node, "name", camera->name, ok);
        hpr_json_number(node, "camera", (double)i, ok);
        add_vector(node, "matrix", matrix, 16, ok);
        hpr_json_number(scene, NULL, cJSON_GetArraySize(nodes) - 1, ok);
    }
}

/* What any viewer reads. */
static hpr_status add_gltf(hpr_glb_builder *glb, const hpr_solution *solution, const hpr_solution_mesh *mesh)
{
    bool *ok = &glb->ok;
    char generator[64];
    snprintf(generator, sizeof generator, "hprad %s", hpr_version());
    cJSON *asset = hpr_json_object(glb->root, "asset", ok);
    hpr_json_text(asset, "version", "2.0", ok);
    hpr_json_text(asset, "generator", generator, ok);
    cJSON *used = hpr_json_array(glb->root, "extensionsUsed", ok);
    hpr_json_text(used, NULL, HPR_EXTENSION_NAME, ok);
    if (mesh->vertex_count)
        hpr_json_text(used, NULL, "KHR_materials_unlit", ok);
    if (!mesh->vertex_count && !solution->camera_count) /* glTF knows no empty list of nodes */
        return HPR_OK;
    hpr_json_number(glb->root, "scene", 0, ok);
    cJSON *scene = hpr_json_object(hpr_json_array(glb->root, "scenes", ok), NULL, ok);
    cJSON *roots = hpr_json_array(scene, "nodes", ok), *nodes = hpr_json_array(glb->root, "nodes", ok);
    hpr_status status = add_mesh(glb, mesh, nodes, roots);
    if (status == HPR_OK)
        add_cameras(glb->root, solution, mesh->radius, nodes, roots, ok);
    return status;
}

static void add_exact_cameras(cJSON *extension, const hpr_solution *solution, bool *ok)
{
    cJSON *cameras = hpr_json_array(extension, "cameras", ok);
    size_t count;
    const hpr_field *fields = hpr_camera_fields(&count);
    for (size_t i = 0; i < solution->camera_count; i++) {
        const hpr_camera *camera = solution->camera + i;
        cJSON *item = hpr_json_object(cameras, NULL, ok);
        hpr_json_text(item, "name", camera->name, ok);
        hpr_json_text(item, "kind", camera->kind == HPR_CAMERA_PERSPECTIVE ? "perspective" : "orthographic",
                      ok);
        for (size_t v = 0; v < HPR_CAMERA_VECTORS; v++)
            add_vector(item, hpr_camera_vectors[v].key,
                       (const double *)(const void *)((const char *)camera + hpr_camera_vectors[v].offset), 3,
                       ok);
        add_fields(item, camera, fields, count, ok);
    }
}

/* Older readers can take what has no emissive textures, no textures or no quadrilaterals. */
static size_t version_of(const hpr_solution *solution)
{
    if (hpr_patches_glow(solution->patches))
        return HPR_EXTENSION_VERSION;
    if (solution->patches->paint)
        return HPR_EXTENSION_VERSION_WITHOUT_GLOW;
    for (size_t i = 0; i < solution->patches->count; i++) {
        if (solution->patches->shape[i] == HPR_SHAPE_QUADRILATERAL)
            return HPR_EXTENSION_VERSION_WITHOUT_TEXTURES;
    }
    return HPR_EXTENSION_VERSION_WITHOUT_QUADRILATERALS;
}

static hpr_status add_extension(hpr_glb_builder *glb, const hpr_solution *solution, double exposure)
{
    bool *ok = &glb->ok;
    size_t version = version_of(solution);
    cJSON *extension = hpr_json_object(hpr_json_object(glb->root, "extensions", ok), HPR_EXTENSION_NAME, ok);
    hpr_json_number(extension, "version", (double)version, ok);
    hpr_json_text(extension, "scene", solution->scene_name, ok);
    hpr_json_number(extension, "exposure", exposure, ok);
    cJSON *channels = hpr_json_array(extension, "channels", ok);
    for (size_t c = 0; c < solution->channel_count; c++)
        hpr_json_text(channels, NULL, solution->channel_name[c], ok);
    cJSON *environment = hpr_json_array(extension, "environment", ok);
    for (size_t c = 0; c < solution->channel_count; c++)
        hpr_json_exact(environment, NULL, solution->environment ? solution->environment[c] : 0, ok);
    const hpr_patches *p = solution->patches;
    const hpr_elements *e = solution->elements;
    const hpr_solution_sizes sizes = {solution->channel_count, p->count, e->node_count, e->leaf_count,
                                      e->dof[e->leaf_count]};
    cJSON *group = hpr_json_object(extension, "patches", ok);
    hpr_json_number(group, "count", (double)sizes.patches, ok);
    hpr_json_number(group, "degenerateCount", (double)p->degenerate_count, ok);
    hpr_json_number(group, "duplicateCount", (double)p->duplicate_count, ok);
    hpr_json_number(group, "weldDistance", p->weld_m, ok);
    group = hpr_json_object(extension, "elements", ok);
    hpr_json_number(group, "count", (double)sizes.nodes, ok);
    hpr_json_number(group, "leafCount", (double)sizes.leaves, ok);
    group = hpr_json_object(extension, "solution", ok);
    hpr_json_number(group, "coefficientCount", (double)sizes.dofs, ok);
    hpr_column columns[HPR_COLUMN_COUNT];
    hpr_solution_columns(&sizes, (hpr_solution *)solution, columns); /* only read */
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < HPR_COLUMN_COUNT; i++) {
        if (columns[i].since <= version)
            status = hpr_column_write(glb, cJSON_GetObjectItemCaseSensitive(extension, columns[i].group),
                                      columns + i);
    }
    if (status == HPR_OK)
        status = hpr_solution_write_paint(glb, extension, p);
    add_exact_cameras(extension, solution, ok);
    size_t count;
    const hpr_field *fields = hpr_summary_fields(&count);
    add_fields(hpr_json_object(extension, "summary", ok), &solution->summary, fields, count, ok);
    cJSON *energy = hpr_json_array(extension, "energy", ok);
    fields = hpr_energy_fields(&count);
    for (size_t c = 0; c < solution->channel_count; c++)
        add_fields(hpr_json_object(energy, NULL, ok), solution->energy + c, fields, count, ok);
    return status;
}

hpr_status hpr_solution_write(hpr_context *ctx, const hpr_solution *solution, const char *path)
{
    hpr_context_clear_error(ctx);
    hpr_glb_builder glb;
    hpr_solution_mesh mesh;
    hpr_glb_builder_init(ctx, &glb);
    hpr_status status = hpr_solution_mesh_init(solution, &mesh);
    if (status == HPR_OK)
        status = add_gltf(&glb, solution, &mesh);
    if (status == HPR_OK)
        status = add_extension(&glb, solution, mesh.exposure);
    if (status == HPR_OK)
        status = hpr_glb_write(&glb, path);
    hpr_solution_mesh_fini(&mesh);
    hpr_glb_builder_fini(&glb);
    return status;
}
