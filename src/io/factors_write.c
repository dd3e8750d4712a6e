#include "io/factors_write.h"

#include "io/json_text.h"

#include <assert.h>
#include <endian.h>
#include <stdio.h>
#include <string.h>

_Static_assert(__BYTE_ORDER == __LITTLE_ENDIAN, "NPY files are written as the machine has its numbers");

/* Magic, version 1.0, length of the rest; the rest ends with a line end and fills up to a multiple of 64.
 * bytes: how many there are, unless NULL. */
static hpr_status write_npy_header(hpr_atomic_file *file, int dimensions, const size_t *shape, size_t *bytes)
{
    enum { PREFIX = 10, ALIGNMENT = 64 };
    char header[256] = "\x93NUMPY\x01";
    assert(dimensions >= 2 && dimensions <= 4);
    char *text = header + PREFIX;
    size_t room = sizeof header - PREFIX, used;
    used = (size_t)snprintf(text, room, "{'descr': '<f8', 'fortran_order': False, 'shape': (");
    for (int i = 0; i < dimensions; i++)
        used +=
            (size_t)snprintf(text + used, room - used, "%zu%s", shape[i], i + 1 < dimensions ? ", " : ")");
    used += (size_t)snprintf(text + used, room - used, ", }");
    size_t total = (PREFIX + used + 1 + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    assert(total <= sizeof header);
    memset(text + used, ' ', total - PREFIX - used);
    header[total - 1] = '\n';
    header[8] = (char)((total - PREFIX) & 0xff);
    header[9] = (char)((total - PREFIX) >> 8);
    if (bytes)
        *bytes = total;
    return hpr_atomic_write(file, header, total);
}

static hpr_status close_file(hpr_atomic_file *file, hpr_status status)
{
    if (status == HPR_OK)
        status = hpr_atomic_commit(file);
    hpr_atomic_abort(file);
    return status;
}

hpr_status hpr_array_write_npy(hpr_context *ctx, const char *path, int dimensions, const size_t *shape,
                               const double *array)
{
    hpr_atomic_file file;
    size_t count = 1;
    for (int i = 0; i < dimensions; i++)
        count *= shape[i];
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = write_npy_header(&file, dimensions, shape, NULL);
    if (status == HPR_OK)
        status = hpr_atomic_write(&file, array, count * sizeof *array);
    return close_file(&file, status);
}

static hpr_status write_binary_line(hpr_atomic_file *file, const double *line, size_t count)
{
    return hpr_atomic_write(file, line, count * sizeof *line);
}

/* count numbers, `separator` between them, and a line end. */
static void print_line(hpr_atomic_file *file, const double *line, size_t count, char separator)
{
    char text[HPR_NUMBER_BYTES];
    for (size_t j = 0; j < count; j++)
        hpr_atomic_print(file, "%s%c", hpr_number_text(line[j], text), j + 1 < count ? separator : '\n');
}

static hpr_status write_csv_line(hpr_atomic_file *file, const double *line, size_t count)
{
    print_line(file, line, count, ',');
    return HPR_OK;
}

static hpr_status write_text_line(hpr_atomic_file *file, const double *line, size_t count)
{
    print_line(file, line, count, ' ');
    return HPR_OK;
}

static hpr_status write_lines(hpr_atomic_file *file, const hpr_factor_source *source,
                              hpr_status (*write)(hpr_atomic_file *, const double *, size_t))
{
    double *line = NULL;
    hpr_status status =
        hpr_allocate_into(file->context, &line, source->count, sizeof *line, "a line of the matrix");
    for (size_t i = 0; status == HPR_OK && i < source->count && !file->reason; i++) {
        source->fetch(source->data, i, line);
        status = write(file, line, source->count);
    }
    hpr_release(file->context, line);
    return status;
}

hpr_status hpr_factors_write_npy(hpr_context *ctx, const char *path, const hpr_factor_source *source)
{
    hpr_atomic_file file;
    const size_t shape[] = {source->count, source->count};
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = write_npy_header(&file, 2, shape, NULL);
    if (status == HPR_OK)
        status = write_lines(&file, source, write_binary_line);
    return close_file(&file, status);
}

hpr_status hpr_factor_file_open(hpr_context *ctx, const char *path, size_t count, const double *area_m2,
                                hpr_factor_file *file)
{
    *file = (hpr_factor_file){.count = count, .area_m2 = area_m2};
    const size_t shape[] = {count, count};
    hpr_status status = hpr_atomic_open(ctx, path, &file->file);
    if (status == HPR_OK)
        status = write_npy_header(&file->file, 2, shape, &file->start);
    return status;
}

/* A piece of line i of the matrix from column j on: count numbers, `stride` from one to the next. */
static hpr_status put_piece(hpr_factor_file *file, size_t i, size_t j, const double *exchange, size_t stride,
                            size_t count)
{
    double line[HPR_FACTOR_TILE_MOST], area = file->area_m2[i];
    assert(count <= HPR_FACTOR_TILE_MOST);
    for (size_t k = 0; k < count; k++)
        line[k] = area > 0 ? exchange[k * stride] / area : 0;
    return hpr_atomic_write_at(&file->file, line, count * sizeof *line,
                               file->start + (i * file->count + j) * sizeof *line);
}

hpr_status hpr_factor_file_put(hpr_factor_file *file, const hpr_factor_tile *tile)
{
    hpr_status status = HPR_OK;
    for (size_t r = 0; r < tile->row_count && status == HPR_OK; r++)
        status = put_piece(file, tile->row + r, tile->column, tile->exchange + r * tile->column_count, 1,
                           tile->column_count);
    for (size_t c = 0; c < tile->column_count && status == HPR_OK && tile->row != tile->column; c++)
        status = put_piece(file, tile->column + c, tile->row, tile->exchange + c, tile->column_count,
                           tile->row_count);
    return status;
}

hpr_status hpr_factor_file_close(hpr_factor_file *file, hpr_status status)
{
    return close_file(&file->file, status);
}

hpr_status hpr_factors_write_csv(hpr_context *ctx, const char *path, const hpr_factor_source *source)
{
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = write_lines(&file, source, write_csv_line);
    return close_file(&file, status);
}

/* One number of every row, on one line. */
static void print_column(hpr_atomic_file *file, const hpr_rows *rows, double (*value)(const hpr_row *))
{
    char text[HPR_NUMBER_BYTES];
    for (size_t i = 0; i < rows->count; i++)
        hpr_atomic_print(file, "%s%c", hpr_number_text(value(&rows->row[i]), text),
                         i + 1 < rows->count ? ' ' : '\n');
}

static double area_of(const hpr_row *row)
{
    return row->area_m2;
}

static double emissivity_of(const hpr_row *row)
{
    return row->emissivity;
}

hpr_status hpr_factors_write_text(hpr_context *ctx, const char *path, const hpr_factor_source *source,
                                  const hpr_rows *rows, bool closed, bool exchange)
{
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK) {
        hpr_atomic_print(&file, "View3D 4.0.0 0 %d %d %zu\n", closed, exchange, rows->count);
        print_column(&file, rows, area_of);
        status = write_lines(&file, source, write_text_line);
    }
    if (status == HPR_OK)
        print_column(&file, rows, emissivity_of);
    return close_file(&file, status);
}

/* Quoted if it must be. */
static void print_name(hpr_atomic_file *file, const char *name)
{
    bool quoted = name[strcspn(name, ",\"\r\n")] != '\0';
    if (!quoted) {
        hpr_atomic_print(file, "%s", name);
        return;
    }
    hpr_atomic_print(file, "\"");
    for (; *name; name++)
        hpr_atomic_print(file, *name == '"' ? "\"\"" : "%c", *name);
    hpr_atomic_print(file, "\"");
}

static void print_surface(hpr_atomic_file *file, size_t index, const hpr_row *row, double row_sum)
{
    const double value[] = {row->area_m2, row->emissivity, row_sum, 1 - row_sum};
    char text[HPR_NUMBER_BYTES];
    hpr_atomic_print(file, "%zu,", index);
    print_name(file, row->name);
    if (row->node == HPR_NONE)
        hpr_atomic_print(file, ",,");
    else
        hpr_atomic_print(file, ",%u,%u", row->node, row->primitive);
    hpr_atomic_print(file, ",%s", row->back ? "back" : "front");
    for (size_t k = 0; k < sizeof value / sizeof *value; k++)
        hpr_atomic_print(file, ",%s", hpr_number_text(value[k], text));
    hpr_atomic_print(file, "\n");
}

hpr_status hpr_surfaces_write(hpr_context *ctx, const char *path, const hpr_rows *rows, const double *row_sum)
{
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK) {
        hpr_atomic_print(&file, "index,name,node,primitive,side,area_m2,emissivity,row_sum,surroundings\n");
        for (size_t i = 0; i < rows->count && !file.reason; i++)
            print_surface(&file, i, &rows->row[i], row_sum[i]);
    }
    return close_file(&file, status);
}
