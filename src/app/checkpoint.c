#include "app/checkpoint.h"

#include "app/scene_hash.h"
#include "io/atomic_file.h"
#include "io/json_text.h"
#include "io/report_parts.h"

#include <hprad/version.h>
#include <stdio.h>
#include <string.h>

enum { VERSION = 2, FIELDS = 8 /* of a refinement */ };

static void note(cJSON *made_of, const char *name, double value, bool *ok)
{
    char text[HPR_NUMBER_BYTES];
    hpr_json_text(made_of, name, hpr_number_text(value, text), ok);
}

static void note_options(cJSON *made_of, const hpr_job_solve_options *options, bool *ok)
{
    const hpr_solve_options *solve = &options->solve;
    note(made_of, "scene-index", options->read.scene_index, ok);
    note(made_of, "max-reflectance", options->read.max_reflectance, ok);
    note(made_of, "metallic", options->read.metallic_black, ok);
    note(made_of, "tol", solve->tolerance, ok);
    hpr_json_text(made_of, "method", hpr_method_name(solve->method), ok);
    hpr_json_text(made_of, "refine", hpr_refine_name(solve->refine), ok);
    note(made_of, "order", solve->order, ok);
    note(made_of, "subdivide", solve->subdivide, ok);
    note(made_of, "feet", solve->feet, ok);
    note(made_of, "element-size", solve->element_size, ok);
    note(made_of, "grade", solve->grade, ok);
    note(made_of, "link-tol", solve->link_tolerance, ok);
    note(made_of, "block-tol", solve->block_tolerance, ok);
    hpr_json_text(made_of, "solver", hpr_solver_name(solve->solver), ok);
    note(made_of, "solver-tol", solve->solver_tolerance, ok);
    note(made_of, "max-sweeps", solve->max_sweeps, ok);
    note(made_of, "direct", solve->direct, ok);
    for (size_t c = 0; c < options->environment_count; c++) {
        char name[48];
        snprintf(name, sizeof name, "environment[%zu]", c);
        note(made_of, name, options->environment[c], ok);
    }
}

hpr_status hpr_checkpoint_open(hpr_context *ctx, const char *scene_path, const hpr_job_solve_options *options,
                               hpr_checkpoint *checkpoint)
{
    bool ok = true;
    char key[HPR_SHA256_TEXT];
    hpr_sha256 hash;
    *checkpoint =
        (hpr_checkpoint){.context = ctx, .path = options->checkpoint_path, .made_of = cJSON_CreateObject()};
    hpr_sha256_init(&hash);
    hpr_status status = hpr_scene_hash_add(ctx, &hash, scene_path);
    hpr_sha256_finish(&hash, key);
    hpr_json_text(checkpoint->made_of, "version", hpr_version(), &ok);
    hpr_json_text(checkpoint->made_of, "commit", hpr_commit(), &ok);
    hpr_json_text(checkpoint->made_of, "isa", hpr_context_isa(ctx), &ok);
    hpr_json_text(checkpoint->made_of, "scene", key, &ok);
    note_options(checkpoint->made_of, options, &ok);
    char *text = ok ? cJSON_PrintUnformatted(checkpoint->made_of) : NULL;
    if (!text)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a checkpoint");
    hpr_sha256_init(&hash);
    hpr_sha256_add_text(&hash, text);
    hpr_sha256_finish(&hash, checkpoint->key);
    cJSON_free(text);
    hpr_block_log_init(ctx, checkpoint->key, &checkpoint->log);
    return status;
}

void hpr_checkpoint_close(hpr_checkpoint *checkpoint)
{
    if (checkpoint->context)
        hpr_release(checkpoint->context, checkpoint->done);
    hpr_block_log_fini(&checkpoint->log);
    cJSON_Delete(checkpoint->made_of);
    *checkpoint = (hpr_checkpoint){0};
}

/* Names the first thing that differs. */
static hpr_status compare(const hpr_checkpoint *checkpoint, const char *path, const cJSON *other)
{
    const cJSON *sides[] = {checkpoint->made_of, other};
    for (int side = 0; side < 2; side++) {
        const cJSON *item;
        cJSON_ArrayForEach(item, sides[side])
        {
            const char *name = item->string;
            const char *now = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(sides[0], name));
            const char *then = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(sides[1], name));
            if (!now || !then || strcmp(now, then) != 0)
                return hpr_fail(checkpoint->context, HPR_ERR_FORMAT,
                                "'%s' was made of something else: %s was %.64s, now it is %.64s", path, name,
                                then ? then : "not there", now ? now : "not there");
        }
    }
    return HPR_OK;
}

static bool take_refinement(const cJSON *item, hpr_refinement *refinement)
{
    static const double most[FIELDS] = {UINT32_MAX,    UINT32_MAX,   1, 1, HPR_MAX_ORDER, HPR_MAX_ORDER,
                                        HPR_MAX_ORDER, HPR_MAX_ORDER};
    size_t value[FIELDS];
    bool good = cJSON_IsArray(item) && cJSON_GetArraySize(item) == FIELDS;
    for (int i = 0; good && i < FIELDS; i++)
        good = hpr_json_read_size(cJSON_GetArrayItem(item, i), most[i], value + i);
    if (good)
        *refinement = (hpr_refinement){
            .step = (uint32_t)value[0],
            .leaf = (uint32_t)value[1],
            .halve = {(uint8_t)value[2], (uint8_t)value[3]},
            .degree = {(uint8_t)value[4], (uint8_t)value[5], (uint8_t)value[6], (uint8_t)value[7]}};
    return good;
}

static hpr_status take(hpr_checkpoint *checkpoint, const char *path, const cJSON *root)
{
    size_t version = 0;
    hpr_context *ctx = checkpoint->context;
    const cJSON *made_of = cJSON_GetObjectItemCaseSensitive(root, "made_of"), *item,
                *list = cJSON_GetObjectItemCaseSensitive(root, "refinements");
    if (!cJSON_IsObject(made_of) || !cJSON_IsArray(list) ||
        !hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(root, "checkpoint"), VERSION, &version) ||
        version != VERSION)
        return hpr_fail(ctx, HPR_ERR_FORMAT, "'%s' is no checkpoint of this version of hprad", path);
    hpr_status status = compare(checkpoint, path, made_of);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &checkpoint->done, (size_t)cJSON_GetArraySize(list),
                                   sizeof *checkpoint->done, "a checkpoint");
    if (status != HPR_OK)
        return status;
    cJSON_ArrayForEach(item, list)
    {
        if (!take_refinement(item, checkpoint->done + checkpoint->done_count))
            return hpr_fail(ctx, HPR_ERR_FORMAT, "'%s': refinement %zu is broken", path,
                            checkpoint->done_count);
        checkpoint->done_count++;
    }
    return HPR_OK;
}

hpr_status hpr_checkpoint_read(hpr_checkpoint *checkpoint, const char *path)
{
    char *text = NULL;
    size_t bytes = 0;
    hpr_status status = hpr_scene_file_read(checkpoint->context, path, &text, &bytes);
    if (status == HPR_OK) {
        cJSON *root = cJSON_ParseWithLength(text, bytes);
        status = take(checkpoint, path, root);
        cJSON_Delete(root);
    }
    hpr_release(checkpoint->context, text);
    return status == HPR_OK ? hpr_block_log_read(&checkpoint->log, path) : status;
}

static hpr_status save(const hpr_checkpoint *checkpoint, const hpr_refinement *refinement, size_t count)
{
    bool ok = true;
    cJSON *root = cJSON_CreateObject();
    hpr_json_number(root, "checkpoint", VERSION, &ok);
    ok = ok && cJSON_AddItemReferenceToObject(root, "made_of", checkpoint->made_of);
    cJSON *list = hpr_json_array(root, "refinements", &ok);
    for (size_t i = 0; i < count && ok; i++) {
        const hpr_refinement *r = refinement + i;
        const double value[FIELDS] = {r->step,      r->leaf,      r->halve[0],  r->halve[1],
                                      r->degree[0], r->degree[1], r->degree[2], r->degree[3]};
        cJSON *item = hpr_json_array(list, NULL, &ok);
        for (int k = 0; k < FIELDS; k++)
            hpr_json_number(item, NULL, value[k], &ok);
    }
    return hpr_report_save(checkpoint->context, root, ok, checkpoint->path);
}

hpr_status hpr_checkpoint_begin(hpr_checkpoint *checkpoint)
{
    if (!checkpoint->path)
        return HPR_OK;
    bool direct = hpr_atomic_is_direct(checkpoint->path); /* a pipe has nothing beside it */
    hpr_status status = direct ? HPR_OK : hpr_block_log_begin(&checkpoint->log, checkpoint->path);
    return status == HPR_OK && !direct ? save(checkpoint, checkpoint->done, checkpoint->done_count) : status;
}

hpr_status hpr_checkpoint_write(void *user, const hpr_refinement *refinement, size_t count)
{
    hpr_checkpoint *checkpoint = user;
    hpr_block_log_forget(&checkpoint->log); /* what it held is among the links of the step that is done */
    hpr_status status = hpr_block_log_flush(&checkpoint->log);
    return status == HPR_OK && checkpoint->path ? save(checkpoint, refinement, count) : status;
}
