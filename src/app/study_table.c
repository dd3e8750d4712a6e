#include "app/study_table.h"

#include "io/atomic_file.h"
#include "io/report_parts.h"

#include <hprad/version.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Columns that tell a row from others; the rest are numbers. */
enum { KEYS = 12, NUMBERS = 27, KEY_BYTES = 512 };

static const char *const key_names[KEYS] = {"scene",  "version",   "commit",    "truth", "options", "method",
                                            "refine", "tolerance", "subdivide", "p",     "grade",   "direct"};

#define AT(member) offsetof(hpr_study_row, member)
static const struct {
    const char *name;
    size_t offset;
} number[NUMBERS] = {
    {"h_m", AT(h_m)},
    {"dofs", AT(dofs)},
    {"elements", AT(elements)},
    {"links", AT(links)},
    {"kernel_evaluations", AT(kernel_evaluations)},
    {"rays", AT(rays)},
    {"clips", AT(clips)},
    {"mesh_cpu_seconds", AT(mesh_cpu_s)},
    {"assembly_cpu_seconds", AT(assembly_cpu_s)},
    {"direct_cpu_seconds", AT(direct_cpu_s)},
    {"environment_cpu_seconds", AT(environment_cpu_s)},
    {"solver_cpu_seconds", AT(solver_cpu_s)},
    {"energy_cpu_seconds", AT(energy_cpu_s)},
    {"estimate_cpu_seconds", AT(estimate_cpu_s)},
    {"cpu_seconds", AT(cpu_s)},
    {"cpu_seconds_least", AT(least_cpu_s)},
    {"cpu_seconds_most", AT(most_cpu_s)},
    {"wall_seconds", AT(wall_s)},
    {"peak_memory_bytes", AT(peak_memory_bytes)},
    {"error_l1", AT(error_l1)},
    {"error_l2", AT(error_l2)},
    {"error_linf", AT(error_linf)},
    {"error_points", AT(error_points)},
    {"error_points_l2", AT(error_points_l2)},
    {"error_face_means", AT(error_face_means)},
    {"error_estimate", AT(error_estimate)},
    {"order_l2", AT(order_l2)},
};
#undef AT

static double *value_of(hpr_study_row *row, int column)
{
    return (double *)(void *)((char *)row + number[column].offset);
}

static const char *refine_text(const hpr_study_run *run)
{
    static const char *const adaptive[] = {
        [HPR_REFINE_HP] = "adaptive hp", [HPR_REFINE_H] = "adaptive h", [HPR_REFINE_P] = "adaptive p"};
    if (run->tolerance > 0)
        return adaptive[run->adapt];
    return run->grade > 0 ? "graded" : "uniform";
}

static void key_text(const hpr_study_labels *labels, const hpr_study_run *run, int column,
                     char text[KEY_BYTES])
{
    char tolerance[HPR_NUMBER_BYTES] = "";
    bool adaptive = run->tolerance > 0;
    if (adaptive)
        hpr_number_text(run->tolerance, tolerance);
    const char *const texts[KEYS] = {labels->scene,
                                     hpr_version(),
                                     hpr_commit(),
                                     labels->truth,
                                     labels->options,
                                     hpr_method_name(run->method),
                                     refine_text(run),
                                     tolerance,
                                     adaptive ? "" : NULL,
                                     adaptive ? "" : NULL,
                                     NULL,
                                     run->direct == HPR_DIRECT_EXACT ? "exact" : "galerkin"};
    const int numbers[KEYS] = {[8] = run->subdivide, [9] = run->order, [10] = run->grade};
    if (texts[column])
        snprintf(text, KEY_BYTES, "%s", texts[column]);
    else
        snprintf(text, KEY_BYTES, "%d", numbers[column]);
}

/* A field in quotes if it needs them. */
static void print_field(hpr_atomic_file *file, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        hpr_atomic_print(file, "%s", text);
        return;
    }
    hpr_atomic_print(file, "\"");
    for (; *text; text++)
        hpr_atomic_print(file, *text == '"' ? "\"\"" : "%c", *text);
    hpr_atomic_print(file, "\"");
}

hpr_status hpr_study_write_csv(hpr_context *ctx, const hpr_study_table *table, const char *path)
{
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK) {
        for (int k = 0; k < KEYS; k++)
            hpr_atomic_print(&file, "%s%s", k ? "," : "", key_names[k]);
        for (int k = 0; k < NUMBERS; k++)
            hpr_atomic_print(&file, ",%s", number[k].name);
        hpr_atomic_print(&file, "\n");
        for (size_t i = 0; i < table->count; i++) {
            char text[KEY_BYTES], digits[HPR_NUMBER_BYTES];
            for (int k = 0; k < KEYS; k++) {
                key_text(&table->labels, &table->row[i].run, k, text);
                hpr_atomic_print(&file, k ? "," : "");
                print_field(&file, text);
            }
            for (int k = 0; k < NUMBERS; k++) {
                double value = *value_of(&table->row[i], k);
                hpr_atomic_print(&file, ",%s", isnan(value) ? "" : hpr_number_text(value, digits));
            }
            hpr_atomic_print(&file, "\n");
        }
        status = hpr_atomic_commit(&file);
    }
    hpr_atomic_abort(&file);
    return status;
}

hpr_status hpr_study_write_json(hpr_context *ctx, const hpr_study_table *table, const char *path)
{
    bool ok = true;
    cJSON *root = cJSON_CreateObject();
    hpr_report_add_program(root, ctx, &ok);
    hpr_json_text(root, "scene", table->labels.scene, &ok);
    hpr_json_text(root, "truth", table->labels.truth, &ok);
    hpr_json_text(root, "options", table->labels.options, &ok);
    cJSON *rows = hpr_json_array(root, "rows", &ok);
    for (size_t i = 0; i < table->count; i++) {
        const hpr_study_run *run = &table->row[i].run;
        bool adaptive = run->tolerance > 0;
        cJSON *item = hpr_json_object(rows, NULL, &ok);
        hpr_json_text(item, "method", hpr_method_name(run->method), &ok);
        hpr_json_text(item, "refine", refine_text(run), &ok);
        hpr_json_number(item, "tolerance", adaptive ? run->tolerance : NAN, &ok);
        hpr_json_number(item, "subdivide", adaptive ? NAN : run->subdivide, &ok);
        hpr_json_number(item, "p", adaptive ? NAN : run->order, &ok);
        hpr_json_number(item, "grade", run->grade, &ok);
        hpr_json_text(item, "direct", run->direct == HPR_DIRECT_EXACT ? "exact" : "galerkin", &ok);
        for (int k = 0; k < NUMBERS; k++)
            hpr_json_number(item, number[k].name, *value_of(&table->row[i], k), &ok);
    }
    hpr_report_add_warnings(root, ctx, &ok);
    return hpr_report_save(ctx, root, ok, path);
}

/* Takes the next field of a line, unquoted; *at then stands behind its comma, or at the end of the line.
 * False if it is longer than any of ours. */
static bool take_field(const char **at, char field[KEY_BYTES])
{
    const char *p = *at;
    size_t length = 0;
    bool quoted = *p == '"';
    p += quoted;
    while (*p && (quoted ? *p != '"' || p[1] == '"' : *p != ',' && *p != '\n')) {
        p += quoted && *p == '"';
        if (length + 1 == KEY_BYTES)
            return false;
        field[length++] = *p++;
    }
    field[length] = 0;
    p += quoted && *p == '"';
    *at = *p == ',' ? p + 1 : p;
    return true;
}

static bool take_row(const hpr_study_labels *labels, const hpr_study_run *run, const char *line,
                     hpr_study_row *row)
{
    char field[KEY_BYTES], expected[KEY_BYTES];
    for (int k = 0; k < KEYS; k++) {
        key_text(labels, run, k, expected);
        if (!take_field(&line, field) || strcmp(field, expected) != 0)
            return false;
    }
    row->run = *run;
    for (int k = 0; k < NUMBERS; k++) {
        char *end;
        if (!take_field(&line, field))
            return false;
        double value = field[0] ? strtod(field, &end) : NAN;
        if (field[0] && *end)
            return false;
        *value_of(row, k) = value;
    }
    return *line == '\n';
}

/* Is the header the one that is written now? */
static bool take_header(const char **at)
{
    char field[KEY_BYTES];
    for (int k = 0; k < KEYS + NUMBERS; k++) {
        if (!take_field(at, field) || strcmp(field, k < KEYS ? key_names[k] : number[k - KEYS].name) != 0)
            return false;
    }
    return **at == '\n';
}

void hpr_study_find(const hpr_study_labels *labels, const hpr_study_run *run, const char *text,
                    hpr_study_row *row, bool *found)
{
    *found = false;
    if (!take_header(&text))
        return;
    while (!*found && (text = strchr(text, '\n')) != NULL && *++text)
        *found = take_row(labels, run, text, row);
}
