#include "io/vs3_lines.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static hpr_status read_failed(const hpr_vs3_lines *in)
{
    if (hpr_cancelled(in->context))
        return hpr_fail(in->context, HPR_ERR_INTERRUPTED, "interrupted while '%s' was read", in->path);
    return hpr_fail(in->context, HPR_ERR_IO, "cannot read '%s': %s", in->path, strerror(errno));
}

hpr_status hpr_vs3_open(hpr_context *ctx, const char *path, hpr_vs3_lines *in)
{
    *in = (hpr_vs3_lines){.context = ctx, .path = path};
    in->stream = fopen(path, "re");
    if (!in->stream)
        return read_failed(in);
    in->locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!in->locale)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: the locale of numbers");
    return HPR_OK;
}

void hpr_vs3_close(hpr_vs3_lines *in)
{
    if (in->stream)
        fclose(in->stream);
    if (in->locale)
        freelocale(in->locale);
    free(in->line); /* getline's */
    *in = (hpr_vs3_lines){0};
}

hpr_status hpr_vs3_next_line(hpr_vs3_lines *in, bool *end)
{
    *end = false;
    for (;;) {
        errno = 0;
        ssize_t length = getline(&in->line, &in->line_capacity, in->stream);
        if (hpr_cancelled(in->context) || ferror(in->stream) || (length < 0 && errno == ENOMEM))
            return read_failed(in);
        *end = length < 0;
        if (*end)
            return HPR_OK;
        in->line_number++;
        if (strlen(in->line) != (size_t)length)
            return hpr_vs3_broken(in, "a zero byte: this is no text file");
        bool marked = in->line_number == 1 && !strncmp(in->line, "\xef\xbb\xbf", 3); /* byte order mark */
        in->at = in->line + (marked ? 3 : 0);
        in->at[strcspn(in->at, "\r\n!/")] = '\0';
        in->at += strspn(in->at, " \t\f\v");
        if (*in->at)
            return HPR_OK;
    }
}

char *hpr_vs3_word(hpr_vs3_lines *in)
{
    char *word = in->at;
    if (!*word)
        return NULL;
    in->at += strcspn(in->at, " \t\f\v");
    if (*in->at)
        *in->at++ = '\0';
    in->at += strspn(in->at, " \t\f\v");
    return word;
}

char *hpr_vs3_rest(hpr_vs3_lines *in)
{
    char *rest = in->at;
    in->at += strlen(in->at);
    for (char *end = in->at; end > rest && isspace((unsigned char)end[-1]); end--)
        end[-1] = '\0';
    return rest;
}

hpr_status hpr_vs3_broken(const hpr_vs3_lines *in, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return hpr_fail(in->context, HPR_ERR_FORMAT, "%s: line %zu: %s", in->path, in->line_number, text);
}

hpr_status hpr_vs3_number(const hpr_vs3_lines *in, const char *word, const char *what, double *value)
{
    if (!word)
        return hpr_vs3_broken(in, "%s is missing", what);
    char *end;
    *value = strtod_l(word, &end, in->locale);
    /* strtod also knows hexadecimals, inf and nan. */
    if (word[strspn(word, "0123456789.+-eE")] || end == word || *end || !isfinite(*value))
        return hpr_vs3_broken(in, "%s: '%.40s' is not a finite number", what, word);
    return HPR_OK;
}

hpr_status hpr_vs3_index(const hpr_vs3_lines *in, const char *word, const char *what, size_t low, size_t high,
                         size_t *value)
{
    if (!word)
        return hpr_vs3_broken(in, "%s is missing", what);
    char *end;
    errno = 0;
    unsigned long long number = strtoull(word, &end, 10);
    if (!isdigit((unsigned char)word[0]) || *end || errno)
        return hpr_vs3_broken(in, "%s: '%.40s' is not a whole number", what, word);
    if (number < low || number > high) {
        if (low > high)
            return hpr_vs3_broken(in, "%s: '%.40s', but there is none yet", what, word);
        return hpr_vs3_broken(in, "%s: '%.40s', expected %zu to %zu", what, word, low, high);
    }
    *value = (size_t)number;
    return HPR_OK;
}
