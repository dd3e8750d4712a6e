/* Points to probe and what was found there, as CSV. */
#ifndef HPR_IO_CSV_POINTS_H
#define HPR_IO_CSV_POINTS_H

#include "base/context.h"

#include <hprad/scene.h>

/*
 * Reads the columns x, y, z, nx, ny, nz, in whatever order the header names them; further columns and empty
 * lines are skipped; LF or CRLF, a byte order mark and "quoted" fields are fine. `path` "-": standard input.
 * point, normal: [count][3], to be released with hpr_release, NULL on failure; the normals need not have
 * length 1, but not 0. Errors (with file, line and column): HPR_ERR_IO, HPR_ERR_FORMAT, HPR_ERR_MEMORY,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_points_read(hpr_context *ctx, const char *path, size_t *count, double **point,
                           double **normal);

/*
 * The same, and the irradiance at the points, [count][channels] W/m2, if the table has the columns of it that
 * hpr_probe_write names for the channels of the scene; else *known is NULL.
 */
hpr_status hpr_points_read_known(hpr_context *ctx, const char *path, const hpr_scene *scene, size_t *count,
                                 double **point, double **normal, double **known);

typedef struct hpr_probe_table {
    size_t count, channel_count;
    const char *const *channel_name;      /* [channels] */
    const double *point, *normal;         /* [count][3] */
    const double *irradiance, *radiosity; /* [count][channels] W/m2, NaN where no patch matches */
    const uint32_t *patch;                /* [count] index, or HPR_NONE where no patch matches */
} hpr_probe_table;

/*
 * Writes x,y,z,nx,ny,nz, irradiance_<channel>..., radiosity_<channel>... (names in lower case), patch (-1:
 * none) and status (ok | nomatch), 17 digits, NaN as nan. `path` NULL or "-": standard output. Errors:
 * HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_probe_write(hpr_context *ctx, const hpr_probe_table *table, const char *path);

#endif
