#include "app/batch_spec.h"

#include "app/names.h"
#include "io/json_place.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A value that is being read: the object it stands in, and its key. */
typedef struct place {
    hpr_batch_spec *spec;
    const char *where; /* "settings[1]", "" for the file's own keys */
    const cJSON *item;
} place;

static hpr_status refuse(const place *p, const char *expected)
{
    char *found = cJSON_PrintUnformatted(p->item);
    const char *key = p->item->string ? p->item->string : "";
    hpr_status status =
        hpr_fail(p->spec->context, HPR_ERR_FORMAT, "%s:%zu: %s%s%s: expected %s, not %.60s", p->spec->path,
                 hpr_json_line(p->spec->text, p->spec->root, p->item), p->where,
                 p->where[0] && key[0] ? "." : "", key, expected, found ? found : "?");
    cJSON_free(found);
    return status;
}

/* How a key is read, into the struct at `base`. */
typedef struct field {
    const char *key;
    hpr_status (*take)(const place *p, const struct field *field, void *base);
    size_t offset;
    double low, high; /* of numbers */
    const char *expected;
} field;

static hpr_status take_integer(const place *p, const field *f, void *base)
{
    double value = p->item->valuedouble;
    if (!cJSON_IsNumber(p->item) || value != floor(value) || !(value >= f->low && value <= f->high)) {
        char expected[64];
        snprintf(expected, sizeof expected, "a whole number from %.0f to %.0f", f->low, f->high);
        return refuse(p, expected);
    }
    *(int *)((char *)base + f->offset) = (int)value;
    return HPR_OK;
}

/* Above low, up to high. */
static hpr_status take_positive(const place *p, const field *f, void *base)
{
    double value = p->item->valuedouble;
    if (!cJSON_IsNumber(p->item) || !(value > f->low && value <= f->high)) {
        char expected[64];
        snprintf(expected, sizeof expected, "a number above %g and up to %g", f->low, f->high);
        return refuse(p, expected);
    }
    *(double *)((char *)base + f->offset) = value;
    return HPR_OK;
}

static hpr_status take_flag(const place *p, const field *f, void *base)
{
    if (!cJSON_IsBool(p->item))
        return refuse(p, "true or false");
    *(int *)((char *)base + f->offset) = cJSON_IsTrue(p->item);
    return HPR_OK;
}

static hpr_status take_text(const place *p, const field *f, void *base)
{
    if (!cJSON_IsString(p->item) || !p->item->valuestring[0])
        return refuse(p, "a text");
    *(const char **)((char *)base + f->offset) = p->item->valuestring;
    return HPR_OK;
}

/* Names go into file names. */
static hpr_status take_name(const place *p, const field *f, void *base)
{
    const char *text = cJSON_GetStringValue(p->item);
    if (!text || !text[0] || strpbrk(text, "/{}") || text[0] == '.')
        return refuse(p, "a name without / { } that does not begin with a dot");
    *(const char **)((char *)base + f->offset) = text;
    return HPR_OK;
}

/* One of the words of f->expected, which has them with | between: its number. */
static hpr_status take_word(const place *p, const field *f, void *base)
{
    const char *text = cJSON_GetStringValue(p->item), *at = f->expected;
    for (int number = 0; text && *text; number++) {
        size_t length = strcspn(at, "|");
        if (strlen(text) == length && !strncmp(text, at, length)) {
            *(int *)((char *)base + f->offset) = number;
            return HPR_OK;
        }
        if (!at[length])
            break;
        at += length + 1;
    }
    return refuse(p, f->expected);
}

/* Up to `most` numbers; *count receives how many. */
static bool read_numbers(const cJSON *item, size_t most, double *value, size_t *count)
{
    *count = 0;
    if (!cJSON_IsArray(item))
        return false;
    for (const cJSON *child = item->child; child; child = child->next) {
        if (*count == most || !cJSON_IsNumber(child) || !isfinite(child->valuedouble))
            return false;
        value[(*count)++] = child->valuedouble;
    }
    return true;
}

/* As many whole numbers as f->low says, from 0 to f->high. */
static hpr_status take_integers(const place *p, const field *f, void *base)
{
    double value[4];
    size_t count;
    bool good = read_numbers(p->item, 4, value, &count) && (double)count == f->low;
    for (size_t i = 0; i < count && good; i++)
        good = value[i] == floor(value[i]) && value[i] >= 0 && value[i] <= f->high;
    if (!good)
        return refuse(p, f->expected);
    for (size_t i = 0; i < count; i++)
        ((int *)((char *)base + f->offset))[i] = (int)value[i];
    return HPR_OK;
}

static hpr_status take_environment(const place *p, const field *f, void *base)
{
    hpr_batch_scene *scene = base;
    bool good = true;
    if (cJSON_IsNumber(p->item)) {
        scene->environment_count = 1;
        scene->environment[0] = p->item->valuedouble;
    } else {
        good = read_numbers(p->item, HPR_BATCH_MAX_CHANNELS, scene->environment, &scene->environment_count) &&
               scene->environment_count;
    }
    for (size_t i = 0; i < scene->environment_count && good; i++)
        good = scene->environment[i] >= 0 && isfinite(scene->environment[i]);
    return good ? HPR_OK : refuse(p, f->expected);
}

static hpr_status take_centre(const place *p, const field *f, void *base)
{
    hpr_batch_camera *camera = base;
    size_t count;
    if (!read_numbers(p->item, 3, camera->options.orbit_centre, &count) || count != 3)
        return refuse(p, f->expected);
    camera->options.orbit_centred = 1;
    return HPR_OK;
}

static hpr_status take_frames(const place *p, const field *f, void *base)
{
    hpr_batch_camera *camera = base;
    double value[2];
    size_t count;
    if (!read_numbers(p->item, 2, value, &count) || count != 2 || !(value[0] >= 0 && value[1] >= value[0]) ||
        value[1] > f->high || value[0] != floor(value[0]) || value[1] != floor(value[1]))
        return refuse(p, f->expected);
    camera->options.first_frame = (int)value[0];
    camera->options.frame_count = (int)(value[1] - value[0]) + 1;
    return HPR_OK;
}

static hpr_status take_layers(const place *p, const field *f, void *base)
{
    hpr_batch_camera *camera = base;
    if (!cJSON_IsArray(p->item))
        return refuse(p, f->expected);
    for (const cJSON *child = p->item->child; child; child = child->next) {
        const char *name = cJSON_GetStringValue(child);
        hpr_layer layer = name ? hpr_layer_find(name, strlen(name)) : HPR_LAYER_COUNT;
        if (layer == HPR_LAYER_COUNT)
            return refuse(p, f->expected);
        camera->options.view.layers |= UINT32_C(1) << layer;
    }
    return HPR_OK;
}

static hpr_status take_false_colour(const place *p, const field *f, void *base)
{
    hpr_batch_camera *camera = base;
    double top = p->item->valuedouble;
    if (cJSON_IsNumber(p->item) && top > 0 && isfinite(top))
        camera->options.false_colour_top = top;
    else if (!cJSON_IsTrue(p->item))
        return refuse(p, f->expected);
    camera->options.false_colour = 1;
    return HPR_OK;
}

#define IN(type, member) offsetof(type, member)
enum { MAX_SIDE = 32768, MAX_ORBIT = 1000000, MAX_SAMPLES = 4096, MAX_FILTER_WIDTH = 16 };

static const field scene_fields[] = {
    {"name", take_name, IN(hpr_batch_scene, name), 0, 0, NULL},
    {"file", take_text, IN(hpr_batch_scene, file), 0, 0, NULL},
    {"scene_index", take_integer, IN(hpr_batch_scene, read.scene_index), 0, 1e6, NULL},
    {"max_reflectance", take_positive, IN(hpr_batch_scene, read.max_reflectance), 0, 1, NULL},
    {"metallic", take_word, IN(hpr_batch_scene, read.metallic_black), 0, 0, "diffuse|black"},
    {"environment", take_environment, 0, 0, 0, "a radiance from 0, or an array with one per channel"},
    {NULL, NULL, 0, 0, 0, NULL}};

static const field setting_fields[] = {
    {"name", take_name, IN(hpr_batch_setting, name), 0, 0, NULL},
    {"order", take_integer, IN(hpr_batch_setting, solve.order), 0, HPR_MAX_ORDER, NULL},
    {"subdivide", take_integer, IN(hpr_batch_setting, solve.subdivide), 0, HPR_MAX_SUBDIVIDE, NULL},
    {"feet", take_integer, IN(hpr_batch_setting, solve.feet), 0, HPR_MAX_FEET, NULL},
    {"grade", take_integer, IN(hpr_batch_setting, solve.grade), 0, HPR_MAX_GRADE, NULL},
    {"tol", take_positive, IN(hpr_batch_setting, solve.tolerance), 0, 0.999999, NULL},
    {"refine", take_word, IN(hpr_batch_setting, solve.refine), 0, 0, "hp|h|p"},
    {"max_time", take_positive, IN(hpr_batch_setting, solve.max_seconds), 0, 1e300, NULL},
    {"max_memory", take_positive, IN(hpr_batch_setting, solve.max_bytes), 0, 1e300, NULL},
    {"link_tol", take_positive, IN(hpr_batch_setting, solve.link_tolerance), 0, 0.999999, NULL},
    {"block_tol", take_positive, IN(hpr_batch_setting, solve.block_tolerance), 0, 0.999999, NULL},
    {"solver", take_word, IN(hpr_batch_setting, solve.solver), 0, 0,
     "auto|gauss-seidel|gmres|gathering|shooting"},
    {"max_sweeps", take_integer, IN(hpr_batch_setting, solve.max_sweeps), 1, 2147483647, NULL},
    {"direct", take_word, IN(hpr_batch_setting, solve.direct), 0, 0, "exact|galerkin"},
    {NULL, NULL, 0, 0, 0, NULL}};

static const field camera_fields[] = {
    {"camera", take_text, IN(hpr_batch_camera, options.camera), 0, 0, NULL},
    {"camera_file", take_text, IN(hpr_batch_camera, options.camera_file), 0, 0, NULL},
    {"orbit", take_integer, IN(hpr_batch_camera, options.orbit), 1, MAX_ORBIT, NULL},
    {"orbit_centre", take_centre, 0, 0, 0, "an array of three numbers, metres"},
    {"frames", take_frames, 0, 0, MAX_ORBIT, "an array of the first and the last number, from 0"},
    {"size", take_integers, IN(hpr_batch_camera, options.render.width), 2, MAX_SIDE,
     "an array of width and height in pixels"},
    {"crop", take_integers, IN(hpr_batch_camera, options.view.crop), 4, MAX_SIDE,
     "an array of x0, y0, x1, y1 in pixels"},
    {"samples", take_integer, IN(hpr_batch_camera, options.render.samples), 1, MAX_SAMPLES, NULL},
    {"filter", take_word, IN(hpr_batch_camera, options.view.filter), 0, 0, "box|gaussian"},
    {"filter_width", take_positive, IN(hpr_batch_camera, options.view.filter_width), 0, MAX_FILTER_WIDTH,
     NULL},
    {"aov", take_layers, 0, 0, 0,
     "an array of irradiance, direct, indirect, emission, albedo, N, P, Z, degree, error, patchId, "
     "elementId"},
    {"half", take_flag, IN(hpr_batch_camera, options.half), 0, 0, NULL},
    {"tiled", take_flag, IN(hpr_batch_camera, options.tiled), 0, 0, NULL},
    {"png", take_flag, IN(hpr_batch_camera, options.preview), 0, 0, NULL},
    {"exposure", take_positive, IN(hpr_batch_camera, options.exposure), 0, 1e300, NULL},
    {"false_colour", take_false_colour, 0, 0, 0, "true, or the legend's top in W/m2"},
    {"pictures", take_text, IN(hpr_batch_camera, pictures), 0, 0, NULL},
    {NULL, NULL, 0, 0, 0, NULL}};

/* Reads every key of an object into `base`. */
static hpr_status take_object(hpr_batch_spec *spec, const char *where, const cJSON *object,
                              const field *fields, void *base)
{
    for (const cJSON *item = object->child; item; item = item->next) {
        const place p = {.spec = spec, .where = where, .item = item};
        const field *f = fields;
        while (f->key && strcmp(f->key, item->string) != 0)
            f++;
        if (!f->key)
            return hpr_fail(spec->context, HPR_ERR_FORMAT, "%s:%zu: %s%s%s: unknown key", spec->path,
                            hpr_json_line(spec->text, spec->root, item), where, where[0] ? "." : "",
                            item->string);
        for (const cJSON *other = object->child; other != item; other = other->next) {
            if (!strcmp(other->string, item->string))
                return refuse(&p, "each key once");
        }
        hpr_status status = f->take(&p, f, base);
        if (status != HPR_OK)
            return status;
    }
    return HPR_OK;
}

static hpr_status fail_at(hpr_batch_spec *spec, const cJSON *item, const char *where, const char *text)
{
    return hpr_fail(spec->context, HPR_ERR_FORMAT, "%s:%zu: %s: %s", spec->path,
                    hpr_json_line(spec->text, spec->root, item), where, text);
}

static hpr_status read_scene(hpr_batch_spec *spec, const cJSON *item, const char *where,
                             hpr_batch_scene *scene)
{
    hpr_status status = HPR_OK;
    scene->item = item;
    hpr_read_options_init(&scene->read);
    if (cJSON_IsString(item) && item->valuestring[0])
        scene->file = item->valuestring;
    else if (cJSON_IsObject(item))
        status = take_object(spec, where, item, scene_fields, scene);
    if (status == HPR_OK && !scene->file)
        return fail_at(spec, item, where, "expected a file name, or an object with the key file");
    if (status != HPR_OK || scene->name)
        return status;
    char *name = hpr_name_default(spec->context, scene->file, "");
    if (name)
        status =
            hpr_grow(spec->context, &spec->made, &spec->made_capacity, spec->made_count + 1, sizeof name);
    if (!name || status != HPR_OK) {
        hpr_release(spec->context, name);
        return hpr_fail(spec->context, HPR_ERR_MEMORY, "out of memory for a name");
    }
    scene->name = spec->made[spec->made_count++] = name;
    if (strpbrk(name, "{}"))
        return fail_at(spec, item, where, "a file name with braces needs a name beside it");
    return HPR_OK;
}

static hpr_status read_setting(hpr_batch_spec *spec, const cJSON *item, const char *where,
                               hpr_batch_setting *setting)
{
    static const char *const with_tolerance[] = {"refine", "max_time", NULL};
    setting->item = item;
    hpr_solve_options_init(&setting->solve);
    if (!cJSON_IsObject(item))
        return fail_at(spec, item, where, "expected an object");
    /* As on the command line: a given subdivision alone makes all elements. */
    if (cJSON_GetObjectItemCaseSensitive(item, "subdivide"))
        setting->solve.feet = 0;
    hpr_status status = take_object(spec, where, item, setting_fields, setting);
    for (int i = 0; status == HPR_OK && !(setting->solve.tolerance > 0) && with_tolerance[i]; i++) {
        const cJSON *given = cJSON_GetObjectItemCaseSensitive(item, with_tolerance[i]);
        if (given)
            return fail_at(spec, given, where, "refine and max_time have an effect only with tol");
    }
    if (status == HPR_OK && !setting->name)
        return fail_at(spec, item, where, "has no name");
    return status;
}

static hpr_status read_camera(hpr_batch_spec *spec, const cJSON *item, const char *where,
                              hpr_batch_camera *camera)
{
    camera->item = item;
    hpr_job_render_options_init(&camera->options);
    if (!cJSON_IsObject(item))
        return fail_at(spec, item, where, "expected an object");
    hpr_status status = take_object(spec, where, item, camera_fields, camera);
    if (status == HPR_OK && camera->options.exposure > 0 && !camera->options.preview)
        return fail_at(spec, item, where, "exposure is for previews only: add \"png\": true");
    if (status == HPR_OK && camera->options.orbit_centred && !camera->options.orbit)
        return fail_at(spec, item, where, "orbit_centre is for orbits only: add orbit");
    return status;
}

/* An array of the file: its length, and room for as many; one if it is not there and may be missing. */
static hpr_status open_array(hpr_batch_spec *spec, const char *key, bool needed, void *memory, size_t size,
                             size_t *count)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(spec->root, key);
    if ((!array && needed) || (array && (!cJSON_IsArray(array) || !array->child)))
        return fail_at(spec, array ? array : spec->root, key, "expected an array that is not empty");
    *count = array ? (size_t)cJSON_GetArraySize(array) : 1;
    return hpr_allocate_into(spec->context, memory, *count, size, "a batch");
}

static hpr_status read_arrays(hpr_batch_spec *spec)
{
    char where[48];
    size_t i = 0;
    hpr_status status =
        open_array(spec, "scenes", true, &spec->scene, sizeof *spec->scene, &spec->scene_count);
    if (status == HPR_OK)
        status =
            open_array(spec, "settings", false, &spec->setting, sizeof *spec->setting, &spec->setting_count);
    if (status == HPR_OK)
        status = open_array(spec, "cameras", false, &spec->camera, sizeof *spec->camera, &spec->camera_count);
    if (status != HPR_OK)
        return status;
    spec->setting[0].name = "default";
    hpr_solve_options_init(&spec->setting[0].solve);
    hpr_job_render_options_init(&spec->camera[0].options);
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(spec->root, "scenes"))
    {
        snprintf(where, sizeof where, "scenes[%zu]", i);
        if (status == HPR_OK)
            status = read_scene(spec, item, where, &spec->scene[i++]);
    }
    i = 0;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(spec->root, "settings"))
    {
        snprintf(where, sizeof where, "settings[%zu]", i);
        spec->setting[i].name = NULL;
        if (status == HPR_OK)
            status = read_setting(spec, item, where, &spec->setting[i++]);
    }
    i = 0;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(spec->root, "cameras"))
    {
        snprintf(where, sizeof where, "cameras[%zu]", i);
        if (status == HPR_OK)
            status = read_camera(spec, item, where, &spec->camera[i++]);
    }
    return status;
}

static hpr_status take_nothing(const place *p, const field *f, void *base)
{
    (void)p;
    (void)f;
    (void)base;
    return HPR_OK; /* arrays are read by themselves */
}

static const field file_fields[] = {{"folder", take_text, IN(hpr_batch_spec, folder), 0, 0, NULL},
                                    {"pictures", take_text, IN(hpr_batch_spec, pictures), 0, 0, NULL},
                                    {"scenes", take_nothing, 0, 0, 0, NULL},
                                    {"settings", take_nothing, 0, 0, 0, NULL},
                                    {"cameras", take_nothing, 0, 0, 0, NULL},
                                    {NULL, NULL, 0, 0, 0, NULL}};

static hpr_status read_text(hpr_batch_spec *spec)
{
    size_t used = 0, capacity = 0;
    FILE *file = fopen(spec->path, "rb");
    if (!file)
        return hpr_fail(spec->context, HPR_ERR_IO, "cannot read '%s': %s", spec->path, strerror(errno));
    hpr_status status = HPR_OK;
    size_t got = 1;
    while (status == HPR_OK && got) {
        status = hpr_grow(spec->context, &spec->text, &capacity, used + 4097, 1);
        got = status == HPR_OK ? fread(spec->text + used, 1, 4096, file) : 0;
        used += got;
    }
    if (status == HPR_OK && ferror(file))
        status = hpr_fail(spec->context, HPR_ERR_IO, "cannot read '%s': %s", spec->path, strerror(errno));
    fclose(file);
    if (status == HPR_OK)
        spec->text[used] = '\0';
    return status;
}

hpr_status hpr_batch_spec_read(hpr_context *ctx, const char *path, hpr_batch_spec *spec)
{
    *spec = (hpr_batch_spec){
        .context = ctx, .path = path, .folder = ".", .pictures = "{scene}_{setting}_{camera}.exr"};
    hpr_status status = read_text(spec);
    if (status != HPR_OK)
        return status;
    const char *end = NULL;
    spec->root = cJSON_ParseWithOpts(spec->text, &end, true);
    if (!spec->root)
        return hpr_fail(ctx, HPR_ERR_FORMAT, "%s:%zu: this is no JSON", path,
                        end ? hpr_json_line_at(spec->text, (size_t)(end - spec->text)) : 1);
    if (!cJSON_IsObject(spec->root))
        return hpr_fail(ctx, HPR_ERR_FORMAT, "%s:1: expected an object with the key scenes", path);
    status = take_object(spec, "", spec->root, file_fields, spec);
    return status == HPR_OK ? read_arrays(spec) : status;
}

void hpr_batch_spec_release(hpr_batch_spec *spec)
{
    for (size_t i = 0; i < spec->made_count; i++)
        hpr_release(spec->context, spec->made[i]);
    if (spec->context) {
        hpr_release(spec->context, spec->made);
        hpr_release(spec->context, spec->scene);
        hpr_release(spec->context, spec->setting);
        hpr_release(spec->context, spec->camera);
        hpr_release(spec->context, spec->text);
    }
    cJSON_Delete(spec->root);
    *spec = (hpr_batch_spec){0};
}
