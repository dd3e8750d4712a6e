/* Reads what solution_write.c describes, believing nothing: every size, index and number is checked before it
 * is used, so that a solution that was read is as sound as one that was solved. */
#include "io/glb.h"
#include "io/json_text.h"
#include "io/solution_column.h"
#include "io/solution_paint.h"
#include "patch/weld.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

/* Trees deeper than any that hprad makes, as walking them may recurse; more channels than any spectrum has.
 */
enum { DEEPEST = 64, MOST_CHANNELS = 65536 };

typedef struct reader {
    hpr_context *context;
    hpr_glb glb;
    const cJSON *extension;
    size_t version;
    hpr_solution_sizes sizes;
    hpr_solution *solution;
} reader;

static hpr_status broken(const reader *r, const char *what)
{
    return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: %s", r->glb.path, HPR_EXTENSION_NAME, what);
}

static const cJSON *member(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

static hpr_status open_extension(reader *r)
{
    r->extension = member(member(r->glb.root, "extensions"), HPR_EXTENSION_NAME);
    if (!cJSON_IsObject(r->extension))
        return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: not an hprad solution (no extension %s)",
                        r->glb.path, HPR_EXTENSION_NAME);
    if (!hpr_json_read_size(member(r->extension, "version"), 0x1p53, &r->version) || r->version < 1)
        return broken(r, "version is missing or broken");
    if (r->version > HPR_EXTENSION_VERSION)
        return hpr_fail(r->context, HPR_ERR_FORMAT,
                        "%s: written by a newer hprad: version %zu of %s, this one reads up to %d",
                        r->glb.path, r->version, HPR_EXTENSION_NAME, HPR_EXTENSION_VERSION);
    return HPR_OK;
}

/* No count can exceed the bytes that the file has, as every item takes one at least. */
static hpr_status read_count(const reader *r, const char *group, const char *key, size_t *value)
{
    double most = fmin((double)r->glb.bin_bytes, UINT32_MAX - 1);
    if (hpr_json_read_size(member(member(r->extension, group), key), most, value))
        return HPR_OK;
    return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: %s.%s is missing, broken or too large", r->glb.path,
                    HPR_EXTENSION_NAME, group, key);
}

static hpr_status read_sizes(reader *r)
{
    const cJSON *channels = member(r->extension, "channels");
    if (!cJSON_IsArray(channels) || cJSON_GetArraySize(channels) < 1 ||
        cJSON_GetArraySize(channels) > MOST_CHANNELS)
        return broken(r, "channels is missing, empty or too long");
    r->sizes.channels = (size_t)cJSON_GetArraySize(channels);
    hpr_status status = read_count(r, "patches", "count", &r->sizes.patches);
    if (status == HPR_OK)
        status = read_count(r, "elements", "count", &r->sizes.nodes);
    if (status == HPR_OK)
        status = read_count(r, "elements", "leafCount", &r->sizes.leaves);
    if (status == HPR_OK)
        status = read_count(r, "solution", "coefficientCount", &r->sizes.dofs);
    if (status == HPR_OK && (r->sizes.nodes < r->sizes.patches || r->sizes.leaves > r->sizes.nodes))
        status = broken(r, "the counts of patches, elements and leaves contradict each other");
    return status;
}

static hpr_status find_column(const reader *r, const hpr_column *column, const unsigned char **data,
                              size_t *bytes)
{
    return hpr_column_find(&r->glb, member(r->extension, column->group), r->version, column, data, bytes);
}

/* All arrays are there before memory is taken for them, so that a small file cannot ask for much. */
static hpr_status check_columns(const reader *r)
{
    hpr_column columns[HPR_COLUMN_COUNT];
    hpr_solution_columns(&r->sizes, NULL, columns);
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < HPR_COLUMN_COUNT; i++) {
        const unsigned char *data;
        size_t bytes;
        status = find_column(r, columns + i, &data, &bytes);
    }
    return status;
}

static hpr_status read_text(const reader *r, const cJSON *item, const char *what, char **text)
{
    const char *value = cJSON_GetStringValue(item);
    if (!value)
        return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: %s is missing or no text", r->glb.path,
                        HPR_EXTENSION_NAME, what);
    *text = hpr_duplicate_text(r->context, value);
    return *text ? HPR_OK : hpr_fail(r->context, HPR_ERR_MEMORY, "out of memory: %s of a solution", what);
}

/* Makes the solution and everything that the columns go into, except what hpr_elements_index derives. */
static hpr_status allocate_solution(reader *r)
{
    hpr_context *ctx = r->context;
    hpr_status status = hpr_allocate_into(ctx, &r->solution, 1, sizeof *r->solution, "a solution");
    if (status != HPR_OK)
        return status;
    hpr_solution *solution = r->solution;
    solution->context = ctx;
    solution->channel_count = r->sizes.channels;
    status = hpr_patches_create(ctx, r->sizes.patches, r->sizes.channels, &solution->patches);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->elements, 1, sizeof *solution->elements, "elements");
    if (status != HPR_OK)
        return status;
    solution->elements->context = ctx;
    solution->elements->node_count = r->sizes.nodes;
    solution->elements->patch_count = r->sizes.patches;
    hpr_column columns[HPR_COLUMN_COUNT];
    hpr_solution_columns(&r->sizes, solution, columns);
    for (size_t i = 0; status == HPR_OK && i < HPR_COLUMN_COUNT; i++) {
        if (!columns[i].derived && strcmp(columns[i].group, "patches") != 0)
            status = hpr_allocate_into(ctx, columns[i].array, columns[i].count * columns[i].components,
                                       hpr_component_bytes(columns[i].component), "a solution");
    }
    return status;
}

/* Copies the arrays, or compares those that the tree has given already. */
static hpr_status take_columns(reader *r, bool derived)
{
    hpr_column columns[HPR_COLUMN_COUNT];
    hpr_solution_columns(&r->sizes, r->solution, columns);
    for (size_t i = 0; i < HPR_COLUMN_COUNT; i++) {
        const unsigned char *data;
        size_t bytes;
        if (columns[i].derived != derived)
            continue;
        hpr_status status = find_column(r, columns + i, &data, &bytes);
        if (status != HPR_OK)
            return status;
        void *array;
        memcpy(&array, columns[i].array, sizeof array);
        if (data && !derived)
            memcpy(array, data, bytes);
        else if (data && memcmp(array, data, bytes) != 0)
            return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: %s.%s contradicts the elements", r->glb.path,
                            HPR_EXTENSION_NAME, columns[i].group, columns[i].key);
    }
    return HPR_OK;
}

static bool all_finite(const double *value, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(value[i]))
            return false;
    }
    return true;
}

static bool all_within(const double *value, size_t count, double low, double high)
{
    for (size_t i = 0; i < count; i++) {
        if (!(value[i] >= low && value[i] <= high))
            return false;
    }
    return true;
}

static bool frame_sound(const double *origin, const double *edge1, const double *edge2, double area_m2)
{
    return all_finite(origin, 3) && all_finite(edge1, 3) && all_finite(edge2, 3) && isfinite(area_m2) &&
           area_m2 > 0;
}

/* Convex, with corners that differ. */
static bool opposite_sound(const hpr_patches *patches, size_t patch, const double *opposite)
{
    return patches->shape[patch] != HPR_SHAPE_QUADRILATERAL ||
           (all_finite(opposite, 2) && opposite[0] > 0 && opposite[1] > 0 && opposite[0] + opposite[1] > 1);
}

static hpr_status check_patches(const reader *r)
{
    const hpr_patches *p = r->solution->patches;
    size_t n = p->channel_count;
    for (size_t i = 0; i < p->count; i++) {
        const double *normal = p->normal + 3 * i;
        double square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
        bool sound = p->shape[i] <= HPR_SHAPE_QUADRILATERAL && p->side[i] <= 1 &&
                     opposite_sound(p, i, p->opposite + 2 * i) &&
                     (p->twin[i] == HPR_NONE || (p->twin[i] < p->count && p->twin[i] != i)) &&
                     frame_sound(p->origin + 3 * i, p->edge1 + 3 * i, p->edge2 + 3 * i, p->area_m2[i]) &&
                     fabs(square - 1) < 1e-6 && all_within(p->reflectance + n * i, n, 0, 1) &&
                     all_within(p->exitance + n * i, n, 0, HUGE_VAL) && all_finite(p->exitance + n * i, n);
        if (!sound)
            return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: patch %zu is not sound", r->glb.path,
                            HPR_EXTENSION_NAME, i);
    }
    return HPR_OK;
}

static bool node_sound(const hpr_patches *patches, const hpr_elements *e, size_t i)
{
    uint32_t child = e->child[i];
    if (e->axis[i] > 1 || e->degree[i] > HPR_MAX_ORDER || e->patch[i] >= e->patch_count ||
        (i < e->patch_count && e->patch[i] != i) ||
        !frame_sound(e->origin + 3 * i, e->edge1 + 3 * i, e->edge2 + 3 * i, e->area_m2[i]) ||
        !opposite_sound(patches, e->patch[i], e->opposite + 2 * i))
        return false;
    if (child == HPR_NONE)
        return true;
    return child >= e->patch_count && child < e->node_count - 1 && e->patch[child] == e->patch[i] &&
           e->patch[child + 1] == e->patch[i];
}

/* Goes through the trees level by level; every node must be met once. `queue`: [node_count] */
static hpr_status walk_trees(const reader *r, uint32_t *queue, uint8_t *depth)
{
    const hpr_elements *e = r->solution->elements;
    size_t filled = e->patch_count;
    for (size_t i = 0; i < filled; i++) {
        queue[i] = (uint32_t)i;
        depth[i] = 1; /* 0: not yet met */
    }
    for (size_t at = 0; at < filled; at++) {
        uint32_t node = queue[at], child = e->child[node];
        if (child == HPR_NONE)
            continue;
        if (depth[child] || depth[child + 1] || depth[node] >= DEEPEST)
            return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: element %u is in two places or too deep",
                            r->glb.path, HPR_EXTENSION_NAME, child);
        for (uint32_t k = child; k < child + 2; k++) {
            queue[filled++] = k;
            depth[k] = (uint8_t)(depth[node] + 1);
        }
    }
    return filled == e->node_count ? HPR_OK : broken(r, "some elements belong to no tree");
}

static hpr_status check_elements(reader *r)
{
    hpr_elements *e = r->solution->elements;
    for (size_t i = 0; i < e->node_count; i++) {
        if (!node_sound(r->solution->patches, e, i))
            return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: element %zu is not sound", r->glb.path,
                            HPR_EXTENSION_NAME, i);
    }
    uint32_t *queue = NULL;
    uint8_t *depth = NULL;
    hpr_status status = hpr_allocate_into(r->context, &queue, e->node_count, sizeof *queue, "trees");
    if (status == HPR_OK)
        status = hpr_allocate_into(r->context, &depth, e->node_count, sizeof *depth, "trees");
    if (status == HPR_OK)
        status = walk_trees(r, queue, depth);
    hpr_release(r->context, queue);
    hpr_release(r->context, depth);
    if (status == HPR_OK)
        status = hpr_elements_index(r->solution->patches, e);
    if (status == HPR_OK && (e->leaf_count != r->sizes.leaves || e->dof[e->leaf_count] != r->sizes.dofs))
        status = broken(r, "the counts of leaves and coefficients contradict the elements");
    return status;
}

static hpr_status check_coefficients(const reader *r)
{
    const hpr_solution *solution = r->solution;
    if (!all_finite(solution->irradiance, r->sizes.dofs * r->sizes.channels))
        return broken(r, "a coefficient of the irradiance is not finite");
    if (!all_within(solution->surroundings, r->sizes.patches * r->sizes.channels, 0, DBL_MAX))
        return broken(r, "the surroundings of a patch are not finite and >= 0");
    for (size_t i = 0; i < r->sizes.leaves; i++) {
        if (solution->error[i] < 0 || isinf(solution->error[i])) /* NaN: unknown */
            return broken(r, "an error estimate is negative or infinite");
    }
    return HPR_OK;
}

static hpr_status read_fields(const reader *r, const cJSON *object, const char *what, void *structure,
                              const hpr_field *fields, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const cJSON *item = member(object, fields[i].key);
        if (!item && fields[i].since > r->version)
            continue;
        char *at = (char *)structure + fields[i].offset;
        double number = 0;
        size_t size = 0;
        bool good = fields[i].kind == HPR_FIELD_DOUBLE ? hpr_json_read_exact(item, &number)
                    : fields[i].kind == HPR_FIELD_INT  ? hpr_json_read_size(item, INT_MAX, &size)
                                                       : hpr_json_read_size(item, 0x1p53, &size);
        if (!good)
            return hpr_fail(r->context, HPR_ERR_FORMAT, "%s: %s: %s: %s is missing or broken", r->glb.path,
                            HPR_EXTENSION_NAME, what, fields[i].key);
        int whole = (int)(size & INT_MAX);
        if (fields[i].kind == HPR_FIELD_DOUBLE)
            memcpy(at, &number, sizeof number);
        else if (fields[i].kind == HPR_FIELD_INT)
            memcpy(at, &whole, sizeof whole);
        else
            memcpy(at, &size, sizeof size);
    }
    return HPR_OK;
}

/* What hpr_scene_add_camera asks for. */
static bool camera_sound(const hpr_camera *camera)
{
    bool view =
        camera->kind == HPR_CAMERA_PERSPECTIVE
            ? camera->yfov_rad > 0 && camera->yfov_rad < 3.14159265358979323846 && camera->aspect >= 0
            : camera->xmag > 0 && camera->ymag > 0 && isfinite(camera->xmag) && isfinite(camera->ymag);
    return view && isfinite(camera->aspect) && isfinite(camera->znear) && !isnan(camera->zfar) &&
           all_finite(camera->origin, 3) && all_finite(camera->right, 3) && all_finite(camera->up, 3) &&
           all_finite(camera->backward, 3);
}

static hpr_status read_camera(const reader *r, const cJSON *item, hpr_camera *camera)
{
    const char *kind = cJSON_GetStringValue(member(item, "kind"));
    bool good = kind && (!strcmp(kind, "perspective") || !strcmp(kind, "orthographic"));
    for (size_t v = 0; good && v < HPR_CAMERA_VECTORS; v++) {
        const cJSON *vector = member(item, hpr_camera_vectors[v].key);
        double value[3];
        good = cJSON_IsArray(vector) && cJSON_GetArraySize(vector) == 3;
        for (int k = 0; good && k < 3; k++)
            good = hpr_json_read_exact(cJSON_GetArrayItem(vector, k), value + k);
        if (good)
            memcpy((char *)camera + hpr_camera_vectors[v].offset, value, sizeof value);
    }
    if (!good)
        return broken(r, "a camera is not sound");
    camera->kind = !strcmp(kind, "perspective") ? HPR_CAMERA_PERSPECTIVE : HPR_CAMERA_ORTHOGRAPHIC;
    size_t count;
    const hpr_field *fields = hpr_camera_fields(&count);
    hpr_status status = read_fields(r, item, "a camera", camera, fields, count);
    if (status == HPR_OK && !camera_sound(camera))
        status = broken(r, "a camera is not sound");
    if (status == HPR_OK)
        status = read_text(r, member(item, "name"), "the name of a camera", &camera->name);
    return status;
}

static hpr_status read_cameras(reader *r)
{
    hpr_solution *solution = r->solution;
    const cJSON *cameras = member(r->extension, "cameras"), *item;
    if (!cJSON_IsArray(cameras))
        return broken(r, "cameras is missing");
    size_t count = (size_t)cJSON_GetArraySize(cameras);
    hpr_status status =
        hpr_allocate_into(r->context, &solution->camera, count, sizeof *solution->camera, "cameras");
    solution->camera_count = status == HPR_OK ? count : 0;
    size_t i = 0;
    cJSON_ArrayForEach(item, cameras)
    {
        if (status == HPR_OK)
            status = read_camera(r, item, solution->camera + i++);
    }
    return status;
}

static hpr_status read_names(reader *r)
{
    hpr_solution *solution = r->solution;
    hpr_status status = read_text(r, member(r->extension, "scene"), "scene", &solution->scene_name);
    if (status == HPR_OK)
        status = hpr_allocate_into(r->context, &solution->channel_name, r->sizes.channels, sizeof(char *),
                                   "channel names");
    const cJSON *item;
    size_t c = 0;
    cJSON_ArrayForEach(item, member(r->extension, "channels"))
    {
        if (status == HPR_OK)
            status = read_text(r, item, "the name of a channel", solution->channel_name + c++);
    }
    return status;
}

static hpr_status read_environment(reader *r)
{
    size_t n = r->sizes.channels;
    const cJSON *environment = member(r->extension, "environment");
    hpr_status status =
        hpr_allocate_into(r->context, &r->solution->environment, n, sizeof(double), "light from outside");
    if (status != HPR_OK || r->version < 2)
        return status;
    bool good = cJSON_IsArray(environment) && (size_t)cJSON_GetArraySize(environment) == n;
    for (size_t c = 0; good && c < n; c++) {
        double *value = r->solution->environment + c;
        good = hpr_json_read_exact(cJSON_GetArrayItem(environment, (int)c), value) && *value >= 0 &&
               isfinite(*value);
    }
    return good ? HPR_OK : broken(r, "environment is missing, broken or not one per channel");
}

/* The first files of version 1 do not say it; then it follows from the scene's size. */
static hpr_status read_weld(reader *r, const cJSON *distance)
{
    hpr_patches *patches = r->solution->patches;
    double low[3], high[3], centre[3], radius = hpr_patches_radius(patches, centre);
    for (int k = 0; k < 3; k++) {
        low[k] = centre[k] - radius;
        high[k] = centre[k] + radius;
    }
    patches->weld_m = hpr_weld_distance(low, high);
    if (!distance && r->version < 2)
        return HPR_OK;
    if (!hpr_json_read_exact(distance, &patches->weld_m) || !(patches->weld_m >= 0))
        return broken(r, "weldDistance is missing or negative");
    return HPR_OK;
}

static hpr_status read_figures(reader *r)
{
    hpr_solution *solution = r->solution;
    const cJSON *energy = member(r->extension, "energy"), *item, *patches = member(r->extension, "patches");
    size_t count, c = 0;
    const hpr_field *fields = hpr_summary_fields(&count);
    solution->summary.error_estimate = NAN;
    hpr_status status =
        read_fields(r, member(r->extension, "summary"), "summary", &solution->summary, fields, count);
    int mode = solution->summary.environment;
    if (status == HPR_OK && mode != HPR_ENVIRONMENT_NONE && mode != HPR_ENVIRONMENT_GALERKIN &&
        mode != HPR_ENVIRONMENT_EXACT)
        status = broken(r, "summary: environment is not sound");
    if (status == HPR_OK &&
        (!cJSON_IsArray(energy) || (size_t)cJSON_GetArraySize(energy) != r->sizes.channels))
        status = broken(r, "energy is missing or not one per channel");
    if (status == HPR_OK &&
        (!hpr_json_read_size(member(patches, "degenerateCount"), 0x1p53,
                             &solution->patches->degenerate_count) ||
         !hpr_json_read_size(member(patches, "duplicateCount"), 0x1p53, &solution->patches->duplicate_count)))
        status = broken(r, "degenerateCount or duplicateCount is missing");
    if (status == HPR_OK)
        status = read_weld(r, member(patches, "weldDistance"));
    if (status == HPR_OK)
        status = hpr_allocate_into(r->context, &solution->energy, r->sizes.channels, sizeof *solution->energy,
                                   "energy terms");
    fields = hpr_energy_fields(&count);
    cJSON_ArrayForEach(item, energy)
    {
        if (status == HPR_OK)
            status = read_fields(r, item, "energy", solution->energy + c++, fields, count);
    }
    return status;
}

static hpr_status read_solution(reader *r)
{
    hpr_status status = open_extension(r);
    if (status == HPR_OK)
        status = read_sizes(r);
    if (status == HPR_OK)
        status = check_columns(r);
    if (status == HPR_OK)
        status = allocate_solution(r);
    if (status == HPR_OK)
        status = take_columns(r, false);
    if (status == HPR_OK)
        status = check_patches(r);
    if (status == HPR_OK)
        status = hpr_solution_read_paint(&r->glb, r->extension, r->version, r->solution->patches);
    if (status == HPR_OK)
        status = check_elements(r);
    if (status == HPR_OK)
        status = take_columns(r, true);
    if (status == HPR_OK)
        status = check_coefficients(r);
    if (status == HPR_OK)
        status = read_names(r);
    if (status == HPR_OK)
        status = read_environment(r);
    if (status == HPR_OK)
        status = read_cameras(r);
    if (status == HPR_OK)
        status = read_figures(r);
    return status;
}

hpr_status hpr_solution_read(hpr_context *ctx, const char *path, hpr_solution **solution)
{
    hpr_context_clear_error(ctx);
    *solution = NULL;
    reader r = {.context = ctx};
    hpr_status status = hpr_glb_read(ctx, path, &r.glb);
    if (status == HPR_OK)
        status = read_solution(&r);
    hpr_glb_fini(&r.glb);
    if (status != HPR_OK)
        hpr_solution_destroy(&r.solution);
    *solution = r.solution;
    return status;
}
