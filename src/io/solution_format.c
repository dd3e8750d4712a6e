#include "io/solution_format.h"

#include <stddef.h>
#include <string.h>

_Static_assert(sizeof(size_t) == sizeof(uint64_t), "offsets of coefficients are written as they are");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are written as they are");

const char *hpr_component_name(hpr_component component)
{
    static const char *const names[] = {"uint8", "uint32", "uint64", "float64", "float32"};
    return names[component];
}

size_t hpr_component_bytes(hpr_component component)
{
    static const size_t bytes[] = {1, 4, 8, 8, 4};
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
        {"patches", "shape", HPR_UINT8, 1, patches, false, 1, OF(p, shape)},
        {"patches", "side", HPR_UINT8, 1, patches, false, 1, OF(p, side)},
        {"patches", "twin", HPR_UINT32, 1, patches, false, 1, OF(p, twin)},
        {"patches", "node", HPR_UINT32, 1, patches, false, 1, OF(p, node)},
        {"patches", "primitive", HPR_UINT32, 1, patches, false, 1, OF(p, primitive)},
        {"patches", "material", HPR_UINT32, 1, patches, false, 1, OF(p, material)},
        {"patches", "origin", HPR_FLOAT64, 3, patches, false, 1, OF(p, origin)},
        {"patches", "edge1", HPR_FLOAT64, 3, patches, false, 1, OF(p, edge1)},
        {"patches", "edge2", HPR_FLOAT64, 3, patches, false, 1, OF(p, edge2)},
        {"patches", "normal", HPR_FLOAT64, 3, patches, false, 1, OF(p, normal)},
        {"patches", "area", HPR_FLOAT64, 1, patches, false, 1, OF(p, area_m2)},
        {"patches", "reflectance", HPR_FLOAT64, n, patches, false, 1, OF(p, reflectance)},
        {"patches", "exitance", HPR_FLOAT64, n, patches, false, 1, OF(p, exitance)},
        {"patches", "opposite", HPR_FLOAT64, 2, patches, false, 4, OF(p, opposite)},
        {"elements", "patch", HPR_UINT32, 1, nodes, false, 1, OF(e, patch)},
        {"elements", "child", HPR_UINT32, 1, nodes, false, 1, OF(e, child)},
        {"elements", "axis", HPR_UINT8, 1, nodes, false, 1, OF(e, axis)},
        {"elements", "degree", HPR_UINT8, 1, nodes, false, 1, OF(e, degree)},
        {"elements", "origin", HPR_FLOAT64, 3, nodes, false, 1, OF(e, origin)},
        {"elements", "edge1", HPR_FLOAT64, 3, nodes, false, 1, OF(e, edge1)},
        {"elements", "edge2", HPR_FLOAT64, 3, nodes, false, 1, OF(e, edge2)},
        {"elements", "area", HPR_FLOAT64, 1, nodes, false, 1, OF(e, area_m2)},
        {"elements", "opposite", HPR_FLOAT64, 2, nodes, false, 4, OF(e, opposite)},
        {"solution", "leaf", HPR_UINT32, 1, leaves, true, 1, OF(e, leaf)},
        {"solution", "firstCoefficient", HPR_UINT64, 1, leaves + 1, true, 1, OF(e, dof)},
        {"solution", "irradiance", HPR_FLOAT64, n, sizes->dofs, false, 1, OF(solution, irradiance)},
        {"solution", "surroundings", HPR_FLOAT64, n, patches, false, 2, OF(solution, surroundings)},
        {"solution", "error", HPR_FLOAT64, 1, leaves, false, 1, OF(solution, error)},
    };
#undef OF
    memcpy(columns, all, sizeof all);
}

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

const hpr_field *hpr_summary_fields(size_t *count)
{
#define AT(member) offsetof(hpr_solve_summary, member)
    static const hpr_field fields[] = {
        {"order", HPR_FIELD_INT, AT(options.order), 1},
        {"subdivide", HPR_FIELD_INT, AT(options.subdivide), 1},
        {"feet", HPR_FIELD_INT, AT(options.feet), 2},
        {"elementSize", HPR_FIELD_DOUBLE, AT(options.element_size), 4}, /* without it: 0 */
        {"errorEstimate", HPR_FIELD_DOUBLE, AT(error_estimate), 4},     /* without it: NaN */
        {"grade", HPR_FIELD_INT, AT(options.grade), 3},
        {"linkToleranceAsked", HPR_FIELD_DOUBLE, AT(options.link_tolerance), 3},
        {"blockTolerance", HPR_FIELD_DOUBLE, AT(options.block_tolerance), 1},
        {"solverAsked", HPR_FIELD_INT, AT(options.solver), 3},
        {"solver", HPR_FIELD_INT, AT(solver), 3},
        {"solverTolerance", HPR_FIELD_DOUBLE, AT(options.solver_tolerance), 1},
        {"maxSweeps", HPR_FIELD_INT, AT(options.max_sweeps), 1},
        {"directAsked", HPR_FIELD_INT, AT(options.direct), 1},
        {"direct", HPR_FIELD_INT, AT(direct), 1},
        {"environment", HPR_FIELD_INT, AT(environment), 2},
        {"environmentClosed", HPR_FIELD_SIZE, AT(environment_closed), 2},
        {"environmentClipped", HPR_FIELD_SIZE, AT(environment_clipped), 2},
        {"environmentSampled", HPR_FIELD_SIZE, AT(environment_sampled), 2},
        {"environmentError", HPR_FIELD_DOUBLE, AT(environment_error), 2},
        {"patchCount", HPR_FIELD_SIZE, AT(patch_count), 1},
        {"elementCount", HPR_FIELD_SIZE, AT(element_count), 1},
        {"dofCount", HPR_FIELD_SIZE, AT(dof_count), 1},
        {"linkCount", HPR_FIELD_SIZE, AT(link_count), 1},
        {"blockBytes", HPR_FIELD_SIZE, AT(block_bytes), 1},
        {"channelsSolved", HPR_FIELD_SIZE, AT(channels_solved), 1},
        {"degenerateCount", HPR_FIELD_SIZE, AT(degenerate_count), 1},
        {"duplicateCount", HPR_FIELD_SIZE, AT(duplicate_count), 1},
        {"linkTolerance", HPR_FIELD_DOUBLE, AT(link_tolerance), 3},
        {"linkError", HPR_FIELD_DOUBLE, AT(link_error), 3},
        {"blockToleranceUsed", HPR_FIELD_DOUBLE, AT(block_tolerance), 1},
        {"blockedTolerance", HPR_FIELD_DOUBLE, AT(blocked_tolerance), 2},
        {"visibilityError", HPR_FIELD_DOUBLE, AT(visibility_error), 3},
        {"shortCount", HPR_FIELD_SIZE, AT(short_count), 1},
        {"blockError", HPR_FIELD_DOUBLE, AT(block_error), 3},
        {"sampledError", HPR_FIELD_DOUBLE, AT(sampled_error), 3},
        {"sweeps", HPR_FIELD_INT, AT(sweeps), 1},
        {"residual", HPR_FIELD_DOUBLE, AT(residual), 1},
        {"occluded", HPR_FIELD_INT, AT(occluded), 1},
        {"method", HPR_FIELD_INT, AT(options.method), 4}, /* without it: Galerkin */
    };
#undef AT
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field *hpr_energy_fields(size_t *count)
{
    static const hpr_field fields[] = {
        {"emitted", HPR_FIELD_DOUBLE, offsetof(hpr_energy, emitted), 1},
        {"environment", HPR_FIELD_DOUBLE, offsetof(hpr_energy, environment), 2},
        {"absorbed", HPR_FIELD_DOUBLE, offsetof(hpr_energy, absorbed), 1},
        {"lostOnBacks", HPR_FIELD_DOUBLE, offsetof(hpr_energy, lost_on_backs), 1},
        {"escaped", HPR_FIELD_DOUBLE, offsetof(hpr_energy, escaped), 1},
    };
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field *hpr_camera_fields(size_t *count)
{
    static const hpr_field fields[] = {
        {"yfov", HPR_FIELD_DOUBLE, offsetof(hpr_camera, yfov_rad), 1},
        {"aspectRatio", HPR_FIELD_DOUBLE, offsetof(hpr_camera, aspect), 1},
        {"xmag", HPR_FIELD_DOUBLE, offsetof(hpr_camera, xmag), 1},
        {"ymag", HPR_FIELD_DOUBLE, offsetof(hpr_camera, ymag), 1},
        {"znear", HPR_FIELD_DOUBLE, offsetof(hpr_camera, znear), 1},
        {"zfar", HPR_FIELD_DOUBLE, offsetof(hpr_camera, zfar), 1},
    };
    *count = COUNT_OF(fields);
    return fields;
}

const hpr_field hpr_camera_vectors[HPR_CAMERA_VECTORS] = {
    {"origin", HPR_FIELD_DOUBLE, offsetof(hpr_camera, origin), 1},
    {"right", HPR_FIELD_DOUBLE, offsetof(hpr_camera, right), 1},
    {"up", HPR_FIELD_DOUBLE, offsetof(hpr_camera, up), 1},
    {"backward", HPR_FIELD_DOUBLE, offsetof(hpr_camera, backward), 1},
};
