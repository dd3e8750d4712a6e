/* The words of a .vs3 file, line by line; what vs3_read.c makes of them is its business. */
#ifndef HPR_IO_VS3_LINES_H
#define HPR_IO_VS3_LINES_H

#include "base/context.h"

#include <locale.h>
#include <stdio.h>

typedef struct hpr_vs3_lines {
    hpr_context *context;
    const char *path; /* for messages */
    FILE *stream;
    locale_t locale; /* numbers have a point, whatever the user's locale */
    char *line;      /* getline's memory */
    size_t line_capacity, line_number;
    char *at; /* in line: the words not yet taken, without comment and line end */
} hpr_vs3_lines;

/* Errors: HPR_ERR_IO, HPR_ERR_MEMORY. Either way the lines can be given to close. */
hpr_status hpr_vs3_open(hpr_context *ctx, const char *path, hpr_vs3_lines *in);
void hpr_vs3_close(hpr_vs3_lines *in);

/* The next line that holds a word; *end at the end of the file. Errors: HPR_ERR_IO, HPR_ERR_FORMAT (a zero
 * byte), HPR_ERR_INTERRUPTED. */
hpr_status hpr_vs3_next_line(hpr_vs3_lines *in, bool *end);

/* The next word of the line, NULL after the last; cut out in place. */
char *hpr_vs3_word(hpr_vs3_lines *in);

/* The rest of the line without blanks around it. */
char *hpr_vs3_rest(hpr_vs3_lines *in);

/* Fails with "FILE: line N: " and the text. */
hpr_status hpr_vs3_broken(const hpr_vs3_lines *in, const char *format, ...) HPR_PRINTF(2, 3);

/* Strict: the whole word, finite, between the bounds. Errors: HPR_ERR_FORMAT, saying `what` was expected. A
 * NULL word is one that is missing. */
hpr_status hpr_vs3_number(const hpr_vs3_lines *in, const char *word, const char *what, double *value);
hpr_status hpr_vs3_index(const hpr_vs3_lines *in, const char *word, const char *what, size_t low, size_t high,
                         size_t *value);

#endif
