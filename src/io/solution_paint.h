/* Textures in a solution file (io/solution_format.h). */
#ifndef HPR_IO_SOLUTION_PAINT_H
#define HPR_IO_SOLUTION_PAINT_H

#include "io/glb.h"
#include "patch/patches.h"

/* Adds the patches' paint to the extension; nothing if there is none. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_solution_write_paint(hpr_glb_builder *glb, cJSON *extension, const hpr_patches *patches);

/* Takes it from a file, believing nothing. Errors: HPR_ERR_FORMAT, HPR_ERR_MEMORY. */
hpr_status hpr_solution_read_paint(const hpr_glb *glb, const cJSON *extension, size_t version,
                                   hpr_patches *patches);

#endif
