/* The tables of the extension HPRAD_radiosity that its writer and its reader share. */
#ifndef HPR_IO_SOLUTION_FORMAT_H
#define HPR_IO_SOLUTION_FORMAT_H

#include "solver/solution.h"

#define HPR_EXTENSION_NAME "HPRAD_radiosity"
enum { HPR_EXTENSION_VERSION = 1 };

typedef enum hpr_component { HPR_UINT8, HPR_UINT32, HPR_UINT64, HPR_FLOAT64 } hpr_component;

/* Name in the file, and bytes. */
const char *hpr_component_name(hpr_component component);
size_t hpr_component_bytes(hpr_component component);

/* The sizes that all arrays follow from. */
typedef struct hpr_solution_sizes {
    size_t channels, patches, nodes, leaves, dofs;
} hpr_solution_sizes;

/* One array of the file: `count` items of `components` numbers each. */
typedef struct hpr_column {
    const char *group, *key; /* object and member within the extension */
    hpr_component component;
    size_t components, count;
    bool derived; /* follows from the others: checked when read, not taken */
    void *array;  /* address of the pointer in the solution, NULL if there is no solution */
} hpr_column;

enum { HPR_COLUMN_COUNT = 25 };

/* Lists the arrays; `solution` may be NULL. */
void hpr_solution_columns(const hpr_solution_sizes *sizes, hpr_solution *solution,
                          hpr_column columns[HPR_COLUMN_COUNT]);

typedef enum hpr_field_kind { HPR_FIELD_INT, HPR_FIELD_SIZE, HPR_FIELD_DOUBLE } hpr_field_kind;

/* A member of a structure that is written by name. */
typedef struct hpr_field {
    const char *key;
    hpr_field_kind kind;
    size_t offset;
} hpr_field;

/* Members of hpr_solve_summary, hpr_energy and the numbers of hpr_camera; *count receives how many. */
const hpr_field *hpr_summary_fields(size_t *count);
const hpr_field *hpr_energy_fields(size_t *count);
const hpr_field *hpr_camera_fields(size_t *count);

/* The four vectors of hpr_camera, as offsets of double[3]. */
enum { HPR_CAMERA_VECTORS = 4 };
extern const hpr_field hpr_camera_vectors[HPR_CAMERA_VECTORS];

#endif
