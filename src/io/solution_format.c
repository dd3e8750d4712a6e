#include "io/solution_format.h"

#include <stddef.h>
#include <string.h>

_Static_assert(sizeof(size_t) == sizeof(uint64_t), "offsets of coefficients are written as they are");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are written as they are");

const char *hpr_component_name(hpr_component component)
{
    static const char *const names[] = {"uint8", "uint32", "uint64", "float64"};
    return names[component];
}

size_t hpr_component_bytes(hpr_component component)
{
    static const size_t bytes[] = {1, 4, 8, 8};
    return bytes[component];
}

void hpr_solution_columns(const hpr_solution_sizes *sizes, hpr_solution *solution,
                          hpr_column columns[HPR_COLUMN_COUNT])
{
    hpr_patches *p = solution ? solution->patches : NULL;
    hpr_elements *e = solution ? solution->elements : NULL;
    size_t n = sizes->channels, patches = sizes->patches, nodes = sizes->nodes, leaves = sizes->leaves;
#define OF(owner, member) ((owner) ? (void *)&(owner)->member : NULL)
    const hpr_column all[HPR_COLUMN_COUNT] = {
        {"patches", "shape", HPR_UINT8, 1, patches, false, OF(p, shape)},
        {"patches", "side", HPR_UINT8, 1, patches, false, OF(p, side)},
        {"patches", "twin", HPR_UINT32, 1, patches, false, OF(p, twin)},
        {"patches", "node", HPR_UINT32, 1, patches, false, OF(p, node)},
        {"patches", "primitive", HPR_UINT32, 1, patches, false, OF(p, primitive)},
        {"patches", "material", HPR_UINT32, 1, patches, false, OF(p, material)},
        {"patches", "origin", HPR_FLOAT64, 3, patches, false, OF(p, origin)},
        {"patches", "edge1", HPR_FLOAT64, 3, patches, false, OF(p, edge1)},
        {"patches", "edge2", HPR_FLOAT64, 3, patches, false, OF(p, edge2)},
        {"patches", "normal", HPR_FLOAT64, 3, patches, false, OF(p, normal)},
        {"patches", "area", HPR_FLOAT64, 1, patches, false, OF(p, area_m2)},
        {"patches", "reflectance", HPR_FLOAT64, n, patches, false, OF(p, reflectance)},
        {"patches", "exitance", HPR_FLOAT64, n, patches, false, OF(p, exitance)},
        {"elements", "patch", HPR_UINT32, 1, nodes, false, OF(e, patch)},
        {"elements", "child", HPR_UINT32, 1, nodes, false, OF(e, child)},
        {"elements", "axis", HPR_UINT8, 1, nodes, false, OF(e, axis)},
        {"elements", "degree", HPR_UINT8, 1, nodes, false, OF(e, degree)},
        {"elements", "origin", HPR_FLOAT64, 3, nodes, false, OF(e, origin)},
        {"elements", "edge1", HPR_FLOAT64, 3, nodes, false, OF(e, edge1)},
        {"elements", "edge2", HPR_FLOAT64, 3, nodes, false, OF(e, edge2)},
        {"elements", "area", HPR_FLOAT64, 1, nodes, false, OF(e, area_m2)},
        {"solution", "leaf", HPR_UINT32, 1, leaves, true, OF(e, leaf)},
        {"solution", "firstCoefficient", HPR_UINT64, 1, leaves + 1, true, OF(e, dof)},
        {"solution", "irradiance", HPR_FLOAT64, n, sizes->dofs, false, OF(solution, irradiance)},
        {"solution", "error", HPR_FLOAT64, 1, leaves, false, OF(solution, error)},
    };
#undef OF
    memcpy(columns, all, sizeof all);
}

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

const hpr_field *hpr_summary_fields(size_t *count)
{
#define AT(member) offsetof(hpr_solve_summary, member)
    static const hpr_field fields[] = {
        {"order", HPR_FIELD_INT, AT(options.order)},
        {"subdivide", HPR_FIELD_INT, AT(options.subdivide)},
        {"feet", HPR_FIELD_INT, AT(options.feet)},
        {"blockTolerance", HPR_FIELD_DOUBLE, AT(options.block_tolerance)},
        {"solverTolerance", HPR_FIELD_DOUBLE, AT(options.solver_tolerance)},
        {"maxSweeps", HPR_FIELD_INT, AT(options.max_sweeps)},
        {"directAsked", HPR_FIELD_INT, AT(options.direct)},
        {"direct", HPR_FIELD_INT, AT(direct)},
        {"patchCount", HPR_FIELD_SIZE, AT(patch_count)},
        {"elementCount", HPR_FIELD_SIZE, AT(element_count)},
        {"dofCount", HPR_FIELD_SIZE, AT(dof_count)},
        {"linkCount", HPR_FIELD_SIZE, AT(link_count)},
        {"blockBytes", HPR_FIELD_SIZE, AT(block_bytes)},
        {"channelsSolved", HPR_FIELD_SIZE, AT(channels_solved)},
        {"degenerateCount", HPR_FIELD_SIZE, AT(degenerate_count)},
        {"duplicateCount", HPR_FIELD_SIZE, AT(duplicate_count)},
        {"blockToleranceUsed", HPR_FIELD_DOUBLE, AT(block_tolerance)},
        {"blockedTolerance", HPR_FIELD_DOUBLE, AT(blocked_tolerance)},
        {"shortCount", HPR_FIELD_SIZE, AT(short_count)},
        {"sweeps", HPR_FIELD_INT, AT(sweeps)},
        {"residual", HPR_FIELD_DOUBLE, AT(residual)},
        {"occluded", HPR_FIELD_INT, AT(occluded)},
    };
#undef AT
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field *hpr_energy_fields(size_t *count)
{
    static const hpr_field fields[] = {
        {"emitted", HPR_FIELD_DOUBLE, offsetof(hpr_energy, emitted)},
        {"absorbed", HPR_FIELD_DOUBLE, offsetof(hpr_energy, absorbed)},
        {"lostOnBacks", HPR_FIELD_DOUBLE, offsetof(hpr_energy, lost_on_backs)},
        {"escaped", HPR_FIELD_DOUBLE, offsetof(hpr_energy, escaped)},
    };
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field *hpr_camera_fields(size_t *count)
{
    static const hpr_field fields[] = {
        {"yfov", HPR_FIELD_DOUBLE, offsetof(hpr_camera, yfov_rad)},
        {"aspectRatio", HPR_FIELD_DOUBLE, offsetof(hpr_camera, aspect)},
        {"xmag", HPR_FIELD_DOUBLE, offsetof(hpr_camera, xmag)},
        {"ymag", HPR_FIELD_DOUBLE, offsetof(hpr_camera, ymag)},
        {"znear", HPR_FIELD_DOUBLE, offsetof(hpr_camera, znear)},
        {"zfar", HPR_FIELD_DOUBLE, offsetof(hpr_camera, zfar)},
    };
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field hpr_camera_vectors[HPR_CAMERA_VECTORS] = {
    {"origin", HPR_FIELD_DOUBLE, offsetof(hpr_camera, origin)},
    {"right", HPR_FIELD_DOUBLE, offsetof(hpr_camera, right)},
    {"up", HPR_FIELD_DOUBLE, offsetof(hpr_camera, up)},
    {"backward", HPR_FIELD_DOUBLE, offsetof(hpr_camera, backward)},
};
