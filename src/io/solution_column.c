#include "io/solution_column.h"

#include "io/json_text.h"

#include <limits.h>
#include <string.h>

hpr_status hpr_column_write(hpr_glb_builder *glb, cJSON *group, const hpr_column *column)
{
    bool *ok = &glb->ok;
    cJSON *array = hpr_json_object(group, column->key, ok);
    size_t bytes = column->count * column->components * hpr_component_bytes(column->component);
    if (bytes) {
        size_t view;
        void *data;
        memcpy(&data, column->array, sizeof data);
        hpr_status status = hpr_glb_add_view(glb, data, bytes, HPR_GLB_NO_TARGET, &view);
        if (status != HPR_OK)
            return status;
        hpr_json_number(array, "bufferView", (double)view, ok);
    }
    hpr_json_text(array, "componentType", hpr_component_name(column->component), ok);
    hpr_json_number(array, "components", (double)column->components, ok);
    hpr_json_number(array, "count", (double)column->count, ok);
    return HPR_OK;
}

hpr_status hpr_column_find(const hpr_glb *glb, const cJSON *group, size_t version, const hpr_column *column,
                           const unsigned char **data, size_t *bytes)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(group, column->key);
    const char *type = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(array, "componentType"));
    size_t count, components, view;
    *data = NULL;
    *bytes = column->count * column->components * hpr_component_bytes(column->component);
    if (!array && column->since > version) {
        *bytes = 0;
        return HPR_OK;
    }
    if (!type || strcmp(type, hpr_component_name(column->component)) ||
        !hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(array, "count"), 0x1p53, &count) ||
        count != column->count ||
        !hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(array, "components"), 0x1p53, &components) ||
        components != column->components)
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s: %s.%s is not %zu times %zu %s", glb->path,
                        HPR_EXTENSION_NAME, column->group, column->key, column->count, column->components,
                        hpr_component_name(column->component));
    if (!*bytes)
        return HPR_OK;
    size_t length;
    if (!hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(array, "bufferView"), INT_MAX, &view))
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s: %s.%s has no buffer view", glb->path,
                        HPR_EXTENSION_NAME, column->group, column->key);
    hpr_status status = hpr_glb_view(glb, view, data, &length);
    if (status == HPR_OK && length != *bytes)
        status = hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s: %s.%s has %zu bytes, not %zu", glb->path,
                          HPR_EXTENSION_NAME, column->group, column->key, length, *bytes);
    return status;
}
