#include "io/csv_points.h"

#include "io/atomic_file.h"
#include "io/json_text.h"
#include "scene/scene.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { COLUMNS = 6 };
static const char *const column_name[COLUMNS] = {"x", "y", "z", "nx", "ny", "nz"};

typedef struct csv {
    hpr_context *context;
    const char *path; /* for messages */
    FILE *stream;
    char *line; /* getline's memory */
    char *text; /* in line: without mark and end, cut into fields in place */
    size_t line_capacity, line_number;
    char **field; /* [field_count] into line */
    size_t field_count, field_capacity;
    locale_t locale; /* numbers are written with a point, whatever the user's locale */
    size_t header_count;
    size_t place[COLUMNS];     /* field of each column */
    const hpr_scene *known_of; /* whose channels are looked for, or NULL */
    size_t *known_place;       /* [channels] field of the irradiance of each; NULL: the table has none */
    double *point, *normal, *known;
    size_t count, point_capacity, normal_capacity, known_capacity;
} csv;

static hpr_status broken(const csv *in, const char *what)
{
    return hpr_fail(in->context, HPR_ERR_FORMAT, "%s: line %zu: %s", in->path, in->line_number, what);
}

static hpr_status read_failed(const csv *in)
{
    if (hpr_cancelled(in->context))
        return hpr_fail(in->context, HPR_ERR_INTERRUPTED, "interrupted while '%s' was read", in->path);
    return hpr_fail(in->context, HPR_ERR_IO, "cannot read '%s': %s", in->path, strerror(errno));
}

/* The next line that is not empty; *end at the end of the file. */
static hpr_status next_line(csv *in, bool *end)
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
            return broken(in, "a zero byte: this is no CSV file");
        bool marked = in->line_number == 1 && !strncmp(in->line, "\xef\xbb\xbf", 3); /* byte order mark */
        in->text = in->line + (marked ? 3 : 0);
        in->text[strcspn(in->text, "\r\n")] = '\0';
        if (in->text[strspn(in->text, " \t")])
            return HPR_OK;
    }
}

/* Ends the field that begins at `begin` and returns where the next one begins, NULL after the last. What
 * follows a closing quote stays part of the field, so that it is not overlooked. */
static char *cut_field(char *begin, char **field)
{
    begin += strspn(begin, " \t");
    char *out = *field = begin;
    if (*begin == '"') {
        for (begin++; *begin && (*begin != '"' || begin[1] == '"'); begin++) {
            if (*begin == '"')
                begin++; /* a doubled quote is one */
            *out++ = *begin;
        }
        begin += *begin == '"';
    }
    while (*begin && *begin != ',')
        *out++ = *begin++;
    bool last = !*begin;
    while (out > *field && (out[-1] == ' ' || out[-1] == '\t'))
        out--;
    *out = '\0';
    return last ? NULL : begin + 1;
}

static hpr_status cut_fields(csv *in)
{
    in->field_count = 0;
    for (char *at = in->text; at;) {
        hpr_status status =
            hpr_grow(in->context, &in->field, &in->field_capacity, in->field_count + 1, sizeof *in->field);
        if (status != HPR_OK)
            return status;
        at = cut_field(at, in->field + in->field_count++);
    }
    return HPR_OK;
}

/* Is this the column of the irradiance of a channel, as hpr_probe_write names it? */
static bool names_irradiance(const char *field, const char *channel)
{
    static const char prefix[] = "irradiance_";
    return !strncmp(field, prefix, sizeof prefix - 1) && !strcasecmp(field + sizeof prefix - 1, channel);
}

/* Irradiance of all channels, or of none. */
static hpr_status find_known(csv *in)
{
    size_t channels = in->known_of ? in->known_of->channel_count : 0, found = 0;
    hpr_status status =
        hpr_allocate_into(in->context, &in->known_place, channels, sizeof *in->known_place, "columns");
    for (size_t i = 0; status == HPR_OK && i < in->field_count; i++) {
        for (size_t c = 0; c < channels; c++) {
            if (!names_irradiance(in->field[i], in->known_of->channel_name[c]))
                continue;
            in->known_place[c] = i;
            found++;
        }
    }
    if (status == HPR_OK && found && found != channels)
        status = hpr_fail(in->context, HPR_ERR_FORMAT,
                          "%s: line %zu: %zu columns 'irradiance_...' in the header, for %zu channels",
                          in->path, in->line_number, found, channels);
    if (!found) {
        hpr_release(in->context, in->known_place);
        in->known_place = NULL;
    }
    return status;
}

static hpr_status read_header(csv *in)
{
    bool end;
    hpr_status status = next_line(in, &end);
    if (status == HPR_OK && end)
        return hpr_fail(in->context, HPR_ERR_FORMAT, "%s: empty; expected the columns x,y,z,nx,ny,nz",
                        in->path);
    if (status == HPR_OK)
        status = cut_fields(in);
    in->header_count = in->field_count;
    for (size_t c = 0; status == HPR_OK && c < COLUMNS; c++) {
        size_t found = 0;
        for (size_t i = 0; i < in->field_count; i++) {
            if (!strcmp(in->field[i], column_name[c])) {
                in->place[c] = i;
                found++;
            }
        }
        if (found != 1)
            status = hpr_fail(in->context, HPR_ERR_FORMAT, "%s: line %zu: %s column '%s' in the header",
                              in->path, in->line_number, found ? "more than one" : "no", column_name[c]);
    }
    return status == HPR_OK ? find_known(in) : status;
}

static hpr_status take_number(const csv *in, size_t place, const char *name, double *value)
{
    const char *text = in->field[place];
    char *end;
    *value = strtod_l(text, &end, in->locale);
    if (end == text || *end || !isfinite(*value))
        return hpr_fail(in->context, HPR_ERR_FORMAT,
                        "%s: line %zu: column '%s': '%.40s' is not a finite number", in->path,
                        in->line_number, name, text);
    return HPR_OK;
}

/* The irradiance of a row, where the table has it. */
static hpr_status read_known(csv *in)
{
    size_t channels = in->known_of->channel_count;
    hpr_status status =
        hpr_grow(in->context, &in->known, &in->known_capacity, in->count + 1, channels * sizeof(double));
    for (size_t c = 0; status == HPR_OK && c < channels; c++)
        status = take_number(in, in->known_place[c], "irradiance", &in->known[channels * in->count + c]);
    return status;
}

static hpr_status read_row(csv *in)
{
    hpr_status status = cut_fields(in);
    if (status == HPR_OK && in->field_count != in->header_count)
        status = hpr_fail(in->context, HPR_ERR_FORMAT, "%s: line %zu: %zu fields, but the header has %zu",
                          in->path, in->line_number, in->field_count, in->header_count);
    double value[COLUMNS] = {0};
    for (size_t c = 0; status == HPR_OK && c < COLUMNS; c++)
        status = take_number(in, in->place[c], column_name[c], &value[c]);
    if (status == HPR_OK && value[3] == 0 && value[4] == 0 && value[5] == 0)
        status = broken(in, "columns 'nx', 'ny', 'nz': the normal is zero");
    if (status == HPR_OK)
        status = hpr_grow(in->context, &in->point, &in->point_capacity, in->count + 1, 3 * sizeof(double));
    if (status == HPR_OK)
        status = hpr_grow(in->context, &in->normal, &in->normal_capacity, in->count + 1, 3 * sizeof(double));
    if (status == HPR_OK && in->known_place)
        status = read_known(in);
    if (status == HPR_OK) {
        memcpy(in->point + 3 * in->count, value, 3 * sizeof(double));
        memcpy(in->normal + 3 * in->count, value + 3, 3 * sizeof(double));
        in->count++;
    }
    return status;
}

static hpr_status read_table(csv *in)
{
    hpr_status status = read_header(in);
    bool end = false;
    while (status == HPR_OK && !end) {
        status = next_line(in, &end);
        if (status == HPR_OK && !end)
            status = read_row(in);
    }
    return status;
}

hpr_status hpr_points_read_known(hpr_context *ctx, const char *path, const hpr_scene *scene, size_t *count,
                                 double **point, double **normal, double **known)
{
    hpr_context_clear_error(ctx);
    bool from_stdin = !strcmp(path, "-");
    csv in = {.context = ctx, .path = from_stdin ? "standard input" : path, .known_of = scene};
    hpr_status status = HPR_OK;
    in.locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    in.stream = from_stdin ? stdin : fopen(path, "re");
    if (!in.stream)
        status = read_failed(&in);
    else if (!in.locale)
        status = hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: the locale of numbers");
    if (status == HPR_OK)
        status = read_table(&in);
    if (in.stream && !from_stdin)
        fclose(in.stream);
    if (in.locale)
        freelocale(in.locale);
    free(in.line); /* getline's */
    hpr_release(ctx, in.field);
    hpr_release(ctx, in.known_place);
    if (status != HPR_OK) {
        hpr_release(ctx, in.point);
        hpr_release(ctx, in.normal);
        hpr_release(ctx, in.known);
        in.point = in.normal = in.known = NULL;
        in.count = 0;
    }
    *count = in.count;
    *point = in.point;
    *normal = in.normal;
    *known = in.known;
    return status;
}

hpr_status hpr_points_read(hpr_context *ctx, const char *path, size_t *count, double **point, double **normal)
{
    double *none;
    return hpr_points_read_known(ctx, path, NULL, count, point, normal, &none);
}

/* "prefix_name" in lower case, quoted if it must be. */
static void print_name(hpr_atomic_file *file, const char *prefix, const char *name)
{
    bool quoted = strpbrk(name, ",\"\r\n") != NULL;
    hpr_atomic_print(file, ",%s%s_", quoted ? "\"" : "", prefix);
    for (; *name; name++) {
        char c = *name >= 'A' && *name <= 'Z' ? (char)(*name - 'A' + 'a') : *name;
        hpr_atomic_print(file, c == '"' ? "\"%c" : "%c", c);
    }
    hpr_atomic_print(file, "%s", quoted ? "\"" : "");
}

static void print_numbers(hpr_atomic_file *file, const double *value, size_t count, bool first)
{
    char text[HPR_NUMBER_BYTES];
    for (size_t i = 0; i < count; i++)
        hpr_atomic_print(file, "%s%s", first && i == 0 ? "" : ",", hpr_number_text(value[i], text));
}

static void print_table(hpr_atomic_file *file, const hpr_probe_table *table)
{
    size_t n = table->channel_count;
    hpr_atomic_print(file, "x,y,z,nx,ny,nz");
    for (size_t c = 0; c < n; c++)
        print_name(file, "irradiance", table->channel_name[c]);
    for (size_t c = 0; c < n; c++)
        print_name(file, "radiosity", table->channel_name[c]);
    hpr_atomic_print(file, ",patch,status\n");
    for (size_t i = 0; i < table->count && !file->reason; i++) {
        print_numbers(file, table->point + 3 * i, 3, true);
        print_numbers(file, table->normal + 3 * i, 3, false);
        print_numbers(file, table->irradiance + n * i, n, false);
        print_numbers(file, table->radiosity + n * i, n, false);
        if (table->patch[i] == HPR_NONE)
            hpr_atomic_print(file, ",-1,nomatch\n");
        else
            hpr_atomic_print(file, ",%u,ok\n", table->patch[i]);
    }
}

hpr_status hpr_probe_write(hpr_context *ctx, const hpr_probe_table *table, const char *path)
{
    hpr_context_clear_error(ctx);
    hpr_atomic_file file;
    bool to_stdout = !path || !strcmp(path, "-");
    hpr_status status = to_stdout ? hpr_atomic_open_stdout(ctx, &file) : hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK) {
        print_table(&file, table);
        status = hpr_atomic_commit(&file);
    }
    hpr_atomic_abort(&file);
    return status;
}
