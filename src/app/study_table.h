/* The rows of a study as files, and as they are found again. */
#ifndef HPR_APP_STUDY_TABLE_H
#define HPR_APP_STUDY_TABLE_H

#include "base/context.h"

#include <hprad/study.h>

/* What all rows of a table have in common: part of what tells them from rows made otherwise. */
typedef struct hpr_study_labels {
    const char *scene;   /* file name without folders */
    const char *truth;   /* what the errors are measured against */
    const char *options; /* everything else that is set, as text */
} hpr_study_labels;

typedef struct hpr_study_table {
    hpr_study_labels labels; /* borrowed */
    size_t count;
    hpr_study_row *row; /* borrowed */
} hpr_study_table;

/* CSV with a header; units stand in the names, what is not known, or not set, is empty. Written anew, and
 * renamed. Errors: HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. */
hpr_status hpr_study_write_csv(hpr_context *ctx, const hpr_study_table *table, const char *path);

/* The same as JSON: what ran, then rows[] with the columns of the CSV as keys. Errors: as above. */
hpr_status hpr_study_write_json(hpr_context *ctx, const hpr_study_table *table, const char *path);

/*
 * Fills *row of the run, if the CSV of an earlier study holds it, with equal labels and of the same version
 * and commit; *found says so. `text` is the file. A file of another make holds nothing.
 */
void hpr_study_find(const hpr_study_labels *labels, const hpr_study_run *run, const char *text,
                    hpr_study_row *row, bool *found);

#endif
