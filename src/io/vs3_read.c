/* From the lines of a .vs3 file to a model. Source of the format: Walton, View3D (NISTIR 6925), 2002. */
#include "io/vs3_read.h"

#include "io/vs3_lines.h"
#include "math/vec3.h"

#include <ctype.h>
#include <string.h>

typedef enum geometry { GEOMETRY_UNKNOWN, GEOMETRY_VERTICES, GEOMETRY_PLANES } geometry;

enum { IGNORED_BYTES = 200 };

typedef struct reader {
    hpr_vs3_lines in;
    hpr_model *model;
    geometry format;
    double *vertex; /* [vertex_count][3] */
    size_t vertex_count, vertex_capacity;
    char ignored[IGNORED_BYTES]; /* control words without effect, ", " between them */
} reader;

/* Words compare without regard to case; the file may be in any. */
static bool same_word(const char *a, const char *b)
{
    for (; *a && *b; a++, b++) {
        if (tolower((unsigned char)*a) != tolower((unsigned char)*b))
            return false;
    }
    return *a == *b;
}

static hpr_status no_more_words(reader *r)
{
    const char *word = hpr_vs3_word(&r->in);
    return word ? hpr_vs3_broken(&r->in, "'%.40s' is one word too many", word) : HPR_OK;
}

static void note_ignored(reader *r, const char *name)
{
    size_t used = strlen(r->ignored), length = strlen(name);
    for (const char *at = r->ignored; (at = strstr(at, name)) != NULL; at += length) {
        bool begins = at == r->ignored || at[-1] == ' ';
        if (begins && (at[length] == ',' || !at[length]))
            return;
    }
    if (used + length + 3 <= IGNORED_BYTES)
        snprintf(r->ignored + used, IGNORED_BYTES - used, "%s%s", used ? ", " : "", name);
}

static hpr_status take_flag(const reader *r, const char *name, const char *value, bool *flag)
{
    size_t number;
    hpr_status status = hpr_vs3_index(&r->in, value, name, 0, 1, &number);
    if (status == HPR_OK)
        *flag = number == 1;
    return status;
}

static hpr_status read_control(reader *r)
{
    char *word;
    hpr_status status = HPR_OK;
    while (status == HPR_OK && (word = hpr_vs3_word(&r->in)) != NULL) {
        char *value = strchr(word, '=');
        if (!value || value == word || !value[1])
            return hpr_vs3_broken(&r->in, "'%.40s': expected name=value", word);
        *value++ = '\0';
        if (same_word(word, "encl"))
            status = take_flag(r, word, value, &r->model->closed);
        else if (same_word(word, "emit"))
            status = take_flag(r, word, value, &r->model->exchange);
        else if (same_word(word, "eps")) {
            status = hpr_vs3_number(&r->in, value, word, &r->model->tolerance);
            if (status == HPR_OK && !(r->model->tolerance > 0 && r->model->tolerance < 1))
                status = hpr_vs3_broken(&r->in, "%s: '%.40s', expected above 0 and below 1", word, value);
        } else {
            note_ignored(r, word);
        }
    }
    return status;
}

static hpr_status read_format(reader *r)
{
    const char *word = hpr_vs3_word(&r->in);
    if (r->format != GEOMETRY_UNKNOWN)
        return hpr_vs3_broken(&r->in, "a second line F");
    if (!word)
        return hpr_vs3_broken(&r->in, "the format is missing, expected 3 or 3a");
    if (same_word(word, "3"))
        r->format = GEOMETRY_VERTICES;
    else if (same_word(word, "3a"))
        r->format = GEOMETRY_PLANES;
    else
        return hpr_fail(r->in.context, HPR_ERR_UNSUPPORTED, "%s: line %zu: format '%.40s', expected 3 or 3a",
                        r->in.path, r->in.line_number, word);
    return no_more_words(r);
}

static hpr_status read_vertex(reader *r)
{
    static const char *const what[] = {"coordinate x", "coordinate y", "coordinate z"};
    if (r->format != GEOMETRY_VERTICES)
        return hpr_vs3_broken(&r->in, "a vertex needs a line 'F 3' before it");
    size_t number, next = r->vertex_count + 1;
    hpr_status status = hpr_vs3_index(&r->in, hpr_vs3_word(&r->in), "number of the vertex (in order from 1)",
                                      next, next, &number);
    if (status == HPR_OK)
        status = hpr_grow(r->in.context, &r->vertex, &r->vertex_capacity, next, 3 * sizeof(double));
    for (size_t k = 0; status == HPR_OK && k < 3; k++)
        status = hpr_vs3_number(&r->in, hpr_vs3_word(&r->in), what[k], &r->vertex[3 * next - 3 + k]);
    if (status == HPR_OK) {
        r->vertex_count = next;
        status = no_more_words(r);
    }
    return status;
}

/* 1-based, 0: none. Only earlier surfaces can be named. */
static hpr_status read_reference(reader *r, const char *what, uint32_t *surface)
{
    size_t number;
    hpr_status status = hpr_vs3_index(&r->in, hpr_vs3_word(&r->in), what, 0, r->model->count, &number);
    if (status == HPR_OK)
        *surface = number ? (uint32_t)(number - 1) : HPR_NONE;
    return status;
}

/* base cmb emit name */
static hpr_status read_properties(reader *r, hpr_surface *s)
{
    hpr_status status = read_reference(r, "base", &s->base);
    if (status == HPR_OK)
        status = read_reference(r, "cmb", &s->combine);
    const char *word = status == HPR_OK ? hpr_vs3_word(&r->in) : NULL;
    if (status == HPR_OK)
        status = hpr_vs3_number(&r->in, word, "emittance", &s->emissivity);
    if (status == HPR_OK && !(s->emissivity >= 0 && s->emissivity <= 1))
        status = hpr_vs3_broken(&r->in, "emittance: '%.40s', expected 0 to 1", word);
    return status;
}

static hpr_status read_corners(reader *r, hpr_surface *s)
{
    s->corner_count = 0;
    for (int i = 0; i < 4; i++) {
        static const char *const what[] = {"vertex v1", "vertex v2", "vertex v3", "vertex v4"};
        size_t number;
        hpr_status status =
            hpr_vs3_index(&r->in, hpr_vs3_word(&r->in), what[i], i == 3 ? 0 : 1, r->vertex_count, &number);
        if (status != HPR_OK)
            return status;
        if (number)
            memcpy(s->corner[s->corner_count++], r->vertex + 3 * (number - 1), sizeof s->corner[0]);
    }
    return HPR_OK;
}

/* Numbers may go on on further lines. */
static hpr_status read_numbers(reader *r, const char *what, double *value, size_t count)
{
    size_t begun = r->in.line_number;
    for (size_t i = 0; i < count; i++) {
        char *word = hpr_vs3_word(&r->in);
        while (!word) {
            bool end;
            hpr_status status = hpr_vs3_next_line(&r->in, &end);
            if (status != HPR_OK)
                return status;
            if (end)
                return hpr_vs3_broken(&r->in, "the file ends within the %s that began in line %zu", what,
                                      begun);
            word = hpr_vs3_word(&r->in);
        }
        hpr_status status = hpr_vs3_number(&r->in, word, what, &value[i]);
        if (status != HPR_OK)
            return status;
    }
    return HPR_OK;
}

/* Exact at multiples of 90 degrees. */
static void sine_and_cosine(double degrees, double *sine, double *cosine)
{
    static const double quarter[] = {0, 1, 0, -1};
    double turn = fmod(degrees, 360);
    double quarters = floor(turn / 90);
    if (turn == 90 * quarters) {
        int k = ((int)quarters + 4) % 4;
        *sine = quarter[k];
        *cosine = quarter[(k + 1) % 4];
    } else {
        *sine = sin(turn * (3.14159265358979323846 / 180));
        *cosine = cos(turn * (3.14159265358979323846 / 180));
    }
}

/* place: origin, azimuth (clockwise from +Y) and tilt (0: facing up). right and up are seen from the front:
 * right x up = normal. */
static void place_corners(hpr_surface *s, const double place[5], const double (*flat)[2])
{
    double sa, ca, st, ct;
    sine_and_cosine(place[3], &sa, &ca);
    sine_and_cosine(place[4], &st, &ct);
    const double right[3] = {-ca, sa, 0}, up[3] = {-ct * sa, -ct * ca, st};
    for (size_t i = 0; i < s->corner_count; i++) {
        for (int k = 0; k < 3; k++)
            s->corner[i][k] = place[k] + (flat[i][0] * right[k] + flat[i][1] * up[k]);
    }
}

static hpr_status read_plane(reader *r, hpr_surface *s, char shape)
{
    double place[5], flat[4][2] = {{0}};
    s->corner_count = shape == 't' ? 3 : 4;
    hpr_status status = read_numbers(r, "origin, azimuth and tilt", place, 5);
    if (status != HPR_OK)
        return status;
    if (shape == 'r') {
        double size[2];
        status = read_numbers(r, "width and height", size, 2);
        if (status == HPR_OK && !(size[0] >= 0 && size[1] >= 0))
            status = hpr_vs3_broken(&r->in, "width and height: %g and %g, expected none below 0", size[0],
                                    size[1]);
        flat[1][0] = flat[2][0] = size[0];
        flat[2][1] = flat[3][1] = size[1];
    } else {
        status = read_numbers(r, "in-plane coordinates", flat[0], 2 * s->corner_count);
    }
    if (status == HPR_OK)
        place_corners(s, place, (const double(*)[2])flat);
    return status == HPR_OK ? no_more_words(r) : status;
}

static hpr_status read_shape(reader *r, char *shape)
{
    const char *word = hpr_vs3_word(&r->in);
    if (!word)
        return hpr_vs3_broken(&r->in, "the shape is missing, expected R, Q or T");
    *shape = (char)tolower((unsigned char)word[0]);
    if (word[1] || !strchr("rqt", *shape))
        return hpr_vs3_broken(&r->in, "shape '%.40s', expected R, Q or T", word);
    return HPR_OK;
}

static hpr_status read_surface(reader *r, hpr_surface_kind kind)
{
    if (r->format == GEOMETRY_UNKNOWN)
        return hpr_vs3_broken(&r->in, "a surface needs a line 'F 3' or 'F 3a' before it");
    hpr_surface s = {.kind = kind, .line = r->in.line_number};
    size_t number, next = r->model->count + 1;
    char shape = 0;
    hpr_status status = hpr_vs3_index(&r->in, hpr_vs3_word(&r->in), "number of the surface (in order from 1)",
                                      next, next, &number);
    if (status == HPR_OK)
        status = r->format == GEOMETRY_VERTICES ? read_corners(r, &s) : read_shape(r, &shape);
    if (status == HPR_OK)
        status = read_properties(r, &s);
    if (status != HPR_OK)
        return status;
    s.name = hpr_duplicate_text(r->in.context, hpr_vs3_rest(&r->in));
    if (!s.name)
        return hpr_fail(r->in.context, HPR_ERR_MEMORY, "out of memory for a model");
    if (r->format == GEOMETRY_PLANES)
        status = read_plane(r, &s, shape);
    if (status == HPR_OK)
        status = hpr_model_add(r->model, &s);
    hpr_release(r->in.context, s.name);
    return status;
}

static hpr_status read_title(reader *r)
{
    hpr_context *ctx = r->in.context;
    hpr_release(ctx, r->model->title);
    r->model->title = hpr_duplicate_text(ctx, hpr_vs3_rest(&r->in));
    return r->model->title ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a model");
}

/* The first letter of the first word decides; *end at the one that ends the data. */
static hpr_status read_line(reader *r, bool *end)
{
    const char *word = hpr_vs3_word(&r->in);
    switch (tolower((unsigned char)word[0])) {
    case 't':
        return read_title(r);
    case 'c':
        return read_control(r);
    case 'f':
        return read_format(r);
    case 'v':
        return read_vertex(r);
    case 's':
        return read_surface(r, HPR_SURFACE_RADIATES);
    case 'o':
        return read_surface(r, HPR_SURFACE_OBSTRUCTS);
    case 'm':
        return read_surface(r, HPR_SURFACE_MASKS);
    case 'n':
        return read_surface(r, HPR_SURFACE_IS_ABSENT);
    case 'e':
    case '*':
        *end = true;
        return HPR_OK;
    case 'x':
        return hpr_fail(r->in.context, HPR_ERR_UNSUPPORTED,
                        "%s: line %zu: '%.40s': coordinate transformations (X) are not supported", r->in.path,
                        r->in.line_number, word);
    default:
        return hpr_vs3_broken(&r->in, "'%.40s' begins no element: expected T, C, F, V, S, O, M, N, E, ! or /",
                              word);
    }
}

static hpr_status read_all(reader *r)
{
    bool end = false;
    hpr_status status = hpr_vs3_next_line(&r->in, &end);
    while (status == HPR_OK && !end) {
        status = read_line(r, &end);
        if (status == HPR_OK && !end)
            status = hpr_vs3_next_line(&r->in, &end);
    }
    if (status == HPR_OK && !r->model->count)
        status = hpr_fail(r->in.context, HPR_ERR_FORMAT, "%s: no surfaces", r->in.path);
    if (status == HPR_OK && r->ignored[0])
        hpr_warn(r->in.context, "%s: control words without effect: %s", r->in.path, r->ignored);
    return status;
}

hpr_status hpr_vs3_read(hpr_context *ctx, const char *path, hpr_model **model)
{
    hpr_context_clear_error(ctx);
    reader r = {.format = GEOMETRY_UNKNOWN};
    *model = NULL;
    hpr_status status = hpr_vs3_open(ctx, path, &r.in);
    if (status == HPR_OK)
        status = hpr_model_create(ctx, path, &r.model);
    if (status == HPR_OK)
        status = read_all(&r);
    if (status == HPR_OK)
        status = hpr_model_check(r.model);
    hpr_vs3_close(&r.in);
    hpr_release(ctx, r.vertex);
    if (status != HPR_OK)
        hpr_model_destroy(&r.model);
    *model = r.model;
    return status;
}
