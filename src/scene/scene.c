#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Sums of exact ones (texture means, interpolated colours) may come out above 1 by rounding. */
static const double reflectance_slack = 1e-12;

void hpr_read_options_init(hpr_read_options *options)
{
    *options = (hpr_read_options){.scene_index = -1};
}

hpr_status hpr_scene_create(hpr_context *ctx, const char *path, size_t channel_count,
                            const char *const *channel_name, hpr_scene **out)
{
    static const char *const rgb[] = {"R", "G", "B"};
    *out = NULL;
    if (channel_count == 0 || (!channel_name && channel_count != 3))
        return hpr_fail(ctx, HPR_ERR_ARG, "a scene of %zu channels needs their names", channel_count);
    hpr_scene *scene = NULL;
    hpr_status status = hpr_allocate_into(ctx, &scene, 1, sizeof *scene, "a scene");
    if (status != HPR_OK)
        return status;
    scene->context = ctx;
    scene->channel_count = channel_count;
    scene->path = hpr_duplicate_text(ctx, path ? path : "");
    if (!scene->path) {
        status = hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a scene's path");
        goto done;
    }
    status = hpr_allocate_into(ctx, &scene->environment, channel_count, sizeof(double), "a scene");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &scene->channel_name, channel_count, sizeof(char *), "channel names");
    for (size_t c = 0; status == HPR_OK && c < channel_count; c++) {
        scene->channel_name[c] = hpr_duplicate_text(ctx, channel_name ? channel_name[c] : rgb[c]);
        if (!scene->channel_name[c])
            status = hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: channel names");
    }
done:
    if (status != HPR_OK)
        hpr_scene_destroy(&scene);
    *out = scene;
    return status;
}

void hpr_scene_destroy(hpr_scene **out)
{
    hpr_scene *scene = *out;
    if (!scene)
        return;
    hpr_context *ctx = scene->context;
    for (size_t c = 0; scene->channel_name && c < scene->channel_count; c++)
        hpr_release(ctx, scene->channel_name[c]);
    for (size_t i = 0; i < scene->material_count; i++)
        hpr_release(ctx, scene->material[i].name);
    for (size_t i = 0; i < scene->mesh_count; i++)
        hpr_release(ctx, scene->mesh_name[i]);
    for (size_t i = 0; i < scene->camera_count; i++)
        hpr_release(ctx, scene->camera[i].name);
    for (size_t i = 0; i < scene->texture_count; i++)
        hpr_release(ctx, scene->texture[i].texel);
    void *arrays[] = {scene->path,
                      scene->channel_name,
                      scene->environment,
                      scene->material,
                      scene->position,
                      scene->material_reflectance,
                      scene->material_radiance,
                      scene->glow_uv,
                      scene->mesh_glow_texture,
                      scene->mesh_glow_factor,
                      scene->face_radiance,
                      scene->uv,
                      scene->colour,
                      scene->mesh_name,
                      scene->mesh_node,
                      scene->mesh_primitive,
                      scene->mesh_material,
                      scene->mesh_texture,
                      scene->mesh_factor,
                      scene->texture,
                      scene->face_vertex,
                      scene->face_mesh,
                      scene->face_reflectance,
                      scene->camera};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, scene);
    *out = NULL;
}

/* Grows arrays that share one capacity; the capacity moves only when all have grown. */
typedef struct column {
    void *array; /* address of the pointer */
    size_t item_bytes;
} column;

static hpr_status grow_columns(hpr_context *ctx, const column *columns, size_t count, size_t *capacity,
                               size_t needed)
{
    size_t grown = *capacity;
    for (size_t i = 0; i < count; i++) {
        size_t own = *capacity;
        hpr_status status = hpr_grow(ctx, columns[i].array, &own, needed, columns[i].item_bytes);
        if (status != HPR_OK)
            return status;
        grown = own;
    }
    *capacity = grown;
    return HPR_OK;
}

hpr_status hpr_scene_add_material(hpr_scene *scene, const char *name, const double *reflectance,
                                  const double *radiance, bool double_sided, uint32_t *index)
{
    hpr_context *ctx = scene->context;
    size_t n = scene->channel_count, i = scene->material_count;
    const char *label = name && name[0] ? name : "(unnamed)";
    for (size_t c = 0; c < n; c++) {
        if (!(reflectance[c] >= 0) || !(reflectance[c] <= 1 + reflectance_slack))
            return hpr_fail(ctx, HPR_ERR_FORMAT,
                            "%s: material %zu '%s': reflectance %g in channel %s is not in [0, 1]",
                            scene->path, i, label, reflectance[c], scene->channel_name[c]);
        if (!(radiance[c] >= 0) || !isfinite(radiance[c]))
            return hpr_fail(ctx, HPR_ERR_FORMAT,
                            "%s: material %zu '%s': emitted radiance %g in channel %s is not finite and >= 0",
                            scene->path, i, label, radiance[c], scene->channel_name[c]);
    }
    const column columns[] = {{&scene->material, sizeof *scene->material},
                              {&scene->material_reflectance, n * sizeof(double)},
                              {&scene->material_radiance, n * sizeof(double)}};
    hpr_status status = grow_columns(ctx, columns, 3, &scene->material_capacity, i + 1);
    if (status != HPR_OK)
        return status;
    char *copy = hpr_duplicate_text(ctx, name ? name : "");
    if (!copy)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a material's name");
    scene->material[i] = (hpr_material){.name = copy, .double_sided = double_sided};
    for (size_t c = 0; c < n; c++) {
        scene->material_reflectance[i * n + c] = fmin(reflectance[c], 1);
        scene->material_radiance[i * n + c] = radiance[c];
    }
    scene->material_count++;
    if (index)
        *index = (uint32_t)i;
    return HPR_OK;
}

hpr_status hpr_scene_add_texture(hpr_scene *scene, const hpr_texture *texture, uint32_t *index)
{
    hpr_context *ctx = scene->context;
    size_t i = scene->texture_count;
    hpr_status status =
        hpr_grow(ctx, &scene->texture, &scene->texture_capacity, i + 1, sizeof *scene->texture);
    if (status == HPR_OK)
        status = hpr_texture_copy(ctx, texture, scene->channel_count, &scene->texture[i]);
    if (status != HPR_OK)
        return status;
    *index = (uint32_t)i;
    scene->texture_count++;
    return HPR_OK;
}

static hpr_status check_mesh(const hpr_scene *scene, const hpr_mesh *mesh)
{
    hpr_context *ctx = scene->context;
    if (mesh->material != HPR_NONE && mesh->material >= scene->material_count)
        return hpr_fail(ctx, HPR_ERR_FORMAT, "%s: node %u, primitive %u: material %u does not exist",
                        scene->path, mesh->node, mesh->primitive, mesh->material);
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        if (!isfinite(mesh->position[i]))
            return hpr_fail(ctx, HPR_ERR_FORMAT,
                            "%s: node %u, primitive %u: vertex %zu has the coordinate %g", scene->path,
                            mesh->node, mesh->primitive, i / 3, mesh->position[i]);
    }
    for (size_t i = 0; i < 4 * mesh->face_count; i++) {
        if (mesh->vertex[i] >= mesh->vertex_count && !(i % 4 == 3 && mesh->vertex[i] == HPR_NONE))
            return hpr_fail(ctx, HPR_ERR_FORMAT,
                            "%s: node %u, primitive %u: face %zu uses vertex %u of %zu vertices", scene->path,
                            mesh->node, mesh->primitive, i / 4, mesh->vertex[i], mesh->vertex_count);
    }
    size_t n = scene->channel_count;
    for (size_t i = 0; mesh->face_reflectance && i < n * mesh->face_count; i++) {
        double rho = mesh->face_reflectance[i];
        if (!(rho >= 0) || !(rho <= 1 + reflectance_slack))
            return hpr_fail(
                ctx, HPR_ERR_FORMAT,
                "%s: node %u, primitive %u, material '%s': face %zu has reflectance %g in channel %s, "
                "which is not in [0, 1]",
                scene->path, mesh->node, mesh->primitive,
                mesh->material == HPR_NONE ? "" : scene->material[mesh->material].name, i / n, rho,
                scene->channel_name[i % n]);
    }
    for (size_t i = 0; mesh->face_radiance && i < n * mesh->face_count; i++) {
        if (!(mesh->face_radiance[i] >= 0) || !isfinite(mesh->face_radiance[i]))
            return hpr_fail(ctx, HPR_ERR_FORMAT,
                            "%s: node %u, primitive %u: face %zu emits the radiance %g in channel %s",
                            scene->path, mesh->node, mesh->primitive, i / n, mesh->face_radiance[i],
                            scene->channel_name[i % n]);
    }
    return HPR_OK;
}

static hpr_status reserve_mesh(hpr_scene *scene, const hpr_mesh *mesh)
{
    hpr_context *ctx = scene->context;
    size_t n = scene->channel_count;
    if (scene->vertex_count + mesh->vertex_count >= HPR_NONE ||
        scene->face_count + mesh->face_count >= HPR_NONE)
        return hpr_fail(ctx, HPR_ERR_UNSUPPORTED, "%s: more than 2^32 - 2 vertices or faces", scene->path);
    const column meshes[] = {
        {&scene->mesh_name, sizeof(char *)},           {&scene->mesh_node, sizeof(uint32_t)},
        {&scene->mesh_primitive, sizeof(uint32_t)},    {&scene->mesh_material, sizeof(uint32_t)},
        {&scene->mesh_texture, sizeof(uint32_t)},      {&scene->mesh_factor, n * sizeof(double)},
        {&scene->mesh_glow_texture, sizeof(uint32_t)}, {&scene->mesh_glow_factor, n * sizeof(double)}};
    const column vertices[] = {{&scene->position, 3 * sizeof(double)},
                               {&scene->uv, 2 * sizeof(double)},
                               {&scene->colour, n * sizeof(double)},
                               {&scene->glow_uv, 2 * sizeof(double)}};
    const column faces[] = {{&scene->face_vertex, 4 * sizeof(uint32_t)},
                            {&scene->face_mesh, sizeof(uint32_t)},
                            {&scene->face_reflectance, n * sizeof(double)},
                            {&scene->face_radiance, n * sizeof(double)}};
    hpr_status status = grow_columns(ctx, meshes, 8, &scene->mesh_capacity, scene->mesh_count + 1);
    if (status == HPR_OK)
        status =
            grow_columns(ctx, vertices, 4, &scene->vertex_capacity, scene->vertex_count + mesh->vertex_count);
    if (status == HPR_OK)
        status = grow_columns(ctx, faces, 4, &scene->face_capacity, scene->face_count + mesh->face_count);
    return status;
}

static void append_vertices(hpr_scene *scene, const hpr_mesh *mesh)
{
    size_t n = scene->channel_count, v0 = scene->vertex_count;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        memcpy(scene->position + 3 * (v0 + v), mesh->position + 3 * v, 3 * sizeof(double));
        for (size_t a = 0; a < 2; a++) {
            scene->uv[2 * (v0 + v) + a] = mesh->uv ? mesh->uv[2 * v + a] : NAN;
            scene->glow_uv[2 * (v0 + v) + a] = mesh->glow_uv ? mesh->glow_uv[2 * v + a] : NAN;
        }
        for (size_t c = 0; c < n; c++)
            scene->colour[n * (v0 + v) + c] = mesh->colour ? mesh->colour[n * v + c] : 1;
    }
    scene->vertex_count += mesh->vertex_count;
}

static void append_faces(hpr_scene *scene, const hpr_mesh *mesh, size_t first_vertex)
{
    static const double default_reflectance = 0.8; /* a primitive without material */
    size_t n = scene->channel_count, f0 = scene->face_count;
    for (size_t f = 0; f < mesh->face_count; f++) {
        for (size_t k = 0; k < 4; k++) {
            uint32_t v = mesh->vertex[4 * f + k];
            scene->face_vertex[4 * (f0 + f) + k] = v == HPR_NONE ? HPR_NONE : v + (uint32_t)first_vertex;
        }
        scene->face_mesh[f0 + f] = (uint32_t)scene->mesh_count;
        for (size_t c = 0; c < n; c++) {
            double rho = mesh->face_reflectance       ? mesh->face_reflectance[n * f + c]
                         : mesh->material == HPR_NONE ? default_reflectance
                                                      : scene->material_reflectance[n * mesh->material + c];
            scene->face_reflectance[n * (f0 + f) + c] = fmin(rho, 1);
            scene->face_radiance[n * (f0 + f) + c] = mesh->face_radiance ? mesh->face_radiance[n * f + c]
                                                     : mesh->material == HPR_NONE
                                                         ? 0
                                                         : scene->material_radiance[n * mesh->material + c];
        }
    }
    scene->face_count += mesh->face_count;
}

hpr_status hpr_scene_add_mesh(hpr_scene *scene, const hpr_mesh *mesh)
{
    hpr_status status = check_mesh(scene, mesh);
    if (status == HPR_OK)
        status = reserve_mesh(scene, mesh);
    if (status != HPR_OK)
        return status;
    char *name = hpr_duplicate_text(scene->context, mesh->name ? mesh->name : "");
    if (!name)
        return hpr_fail(scene->context, HPR_ERR_MEMORY, "out of memory: a mesh's name");
    size_t first_vertex = scene->vertex_count, m = scene->mesh_count;
    append_vertices(scene, mesh);
    append_faces(scene, mesh, first_vertex);
    scene->mesh_name[m] = name;
    scene->mesh_node[m] = mesh->node;
    scene->mesh_primitive[m] = mesh->primitive;
    scene->mesh_material[m] = mesh->material;
    scene->mesh_texture[m] = mesh->factor ? mesh->texture : HPR_NONE;
    for (size_t c = 0; mesh->factor && c < scene->channel_count; c++)
        scene->mesh_factor[scene->channel_count * m + c] = mesh->factor[c];
    scene->mesh_glow_texture[m] = mesh->glow_factor ? mesh->glow_texture : HPR_NONE;
    for (size_t c = 0; mesh->glow_factor && c < scene->channel_count; c++)
        scene->mesh_glow_factor[scene->channel_count * m + c] = mesh->glow_factor[c];
    scene->mesh_count++;
    return HPR_OK;
}

hpr_status hpr_scene_add_camera(hpr_scene *scene, const hpr_camera *camera)
{
    hpr_context *ctx = scene->context;
    size_t i = scene->camera_count;
    bool finite = isfinite(camera->aspect);
    for (int a = 0; a < 3; a++)
        finite = finite && isfinite(camera->origin[a]) && isfinite(camera->right[a]) &&
                 isfinite(camera->up[a]) && isfinite(camera->backward[a]);
    bool depth = camera->znear >= 0 && camera->znear < camera->zfar; /* false for NaN */
    bool view =
        camera->kind == HPR_CAMERA_PERSPECTIVE
            ? camera->yfov_rad > 0 && camera->yfov_rad < 3.14159265358979323846 && camera->aspect >= 0
            : camera->xmag > 0 && camera->ymag > 0 && isfinite(camera->xmag) && isfinite(camera->ymag);
    if (!finite || !depth || !view)
        return hpr_fail(ctx, HPR_ERR_FORMAT,
                        "%s: camera %zu '%s' sees nothing (check yfov, aspectRatio, xmag, ymag, "
                        "znear, zfar and its node's matrix)",
                        scene->path, i, camera->name ? camera->name : "");
    hpr_status status = hpr_grow(ctx, &scene->camera, &scene->camera_capacity, i + 1, sizeof *scene->camera);
    if (status != HPR_OK)
        return status;
    char *name = hpr_duplicate_text(ctx, camera->name ? camera->name : "");
    if (!name)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a camera's name");
    scene->camera[i] = *camera;
    scene->camera[i].name = name;
    scene->camera_count++;
    return HPR_OK;
}

/* Scales `rho` [channels] so that its largest channel is at most `limit`; true if it changed. */
static bool limit_channels(double *rho, size_t channel_count, double limit)
{
    double largest = 0;
    for (size_t c = 0; c < channel_count; c++)
        largest = fmax(largest, rho[c]);
    if (largest <= limit)
        return false;
    for (size_t c = 0; c < channel_count; c++)
        rho[c] = fmin(rho[c] * (limit / largest), limit); /* the product may round up */
    return true;
}

/* The largest value of a channel of a texture. */
static double texture_peak(const hpr_texture *texture, size_t channel_count, size_t channel)
{
    double peak = 0;
    for (size_t i = 0; i < (size_t)texture->width * texture->height; i++)
        peak = fmax(peak, (double)texture->texel[channel_count * i + channel]);
    return peak;
}

/* Scales a mesh with a texture, means and factor alike, so that the two stay consistent. Returns the number
 * of faces that changed. */
static size_t limit_texture(hpr_scene *scene, size_t mesh, double limit)
{
    size_t n = scene->channel_count, faces = 0;
    const hpr_texture *texture = &scene->texture[scene->mesh_texture[mesh]];
    double largest = 0;
    for (size_t c = 0; c < n; c++) {
        double colour = 0;
        for (size_t i = 0; i < 4 * scene->face_count; i++) {
            if (scene->face_mesh[i / 4] == mesh && scene->face_vertex[i] != HPR_NONE)
                colour = fmax(colour, scene->colour[n * scene->face_vertex[i] + c]);
        }
        largest = fmax(largest, colour * scene->mesh_factor[n * mesh + c] * texture_peak(texture, n, c));
    }
    if (largest <= limit)
        return 0;
    for (size_t c = 0; c < n; c++)
        scene->mesh_factor[n * mesh + c] *= limit / largest;
    for (size_t f = 0; f < scene->face_count; f++) {
        if (scene->face_mesh[f] != mesh)
            continue;
        for (size_t c = 0; c < n; c++)
            scene->face_reflectance[n * f + c] *= limit / largest;
        faces++;
    }
    return faces;
}

hpr_status hpr_scene_set_environment(hpr_scene *scene, size_t count, const double *radiance)
{
    hpr_context *ctx = scene->context;
    hpr_context_clear_error(ctx);
    if (count != 1 && count != scene->channel_count)
        return hpr_fail(
            ctx, HPR_ERR_ARG,
            "%s: %zu radiances from outside: expected one for all channels or one for each of %zu",
            scene->path, count, scene->channel_count);
    for (size_t i = 0; i < count; i++) {
        if (!(radiance[i] >= 0) || !isfinite(radiance[i]))
            return hpr_fail(ctx, HPR_ERR_ARG, "%s: the radiance from outside is %g, not finite and >= 0",
                            scene->path, radiance[i]);
    }
    for (size_t c = 0; c < scene->channel_count; c++)
        scene->environment[c] = radiance[count == 1 ? 0 : c];
    return HPR_OK;
}

hpr_status hpr_scene_limit_reflectance(hpr_scene *scene, double limit)
{
    hpr_context *ctx = scene->context;
    if (!(limit > 0 && limit <= 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "the largest reflectance must be in (0, 1], not %g", limit);
    size_t n = scene->channel_count, faces = 0;
    for (size_t i = 0; i < scene->material_count; i++) {
        if (limit_channels(scene->material_reflectance + n * i, n, limit))
            hpr_warn(ctx, "%s: material %zu '%s' scaled down to reflectance %g", scene->path, i,
                     scene->material[i].name, limit);
    }
    for (size_t m = 0; m < scene->mesh_count; m++)
        faces += scene->mesh_texture[m] != HPR_NONE ? limit_texture(scene, m, limit) : 0;
    for (size_t f = 0; f < scene->face_count; f++)
        faces += limit_channels(scene->face_reflectance + n * f, n, limit);
    if (faces)
        hpr_warn(ctx, "%s: %zu faces scaled down to reflectance %g", scene->path, faces, limit);
    return HPR_OK;
}

bool hpr_scene_bounds(const hpr_scene *scene, double low[3], double high[3])
{
    for (int a = 0; a < 3; a++) {
        low[a] = INFINITY;
        high[a] = -INFINITY;
    }
    for (size_t i = 0; i < 4 * scene->face_count; i++) {
        uint32_t v = scene->face_vertex[i];
        for (int a = 0; v != HPR_NONE && a < 3; a++) {
            low[a] = fmin(low[a], scene->position[3 * v + a]);
            high[a] = fmax(high[a], scene->position[3 * v + a]);
        }
    }
    return scene->face_count > 0;
}
