/* Irradiance in colours, with a legend. */
#include "io/glyphs.h"
#include "io/png_file.h"

#include <hprad/render.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A picture in the making: RGB, 8 bits. */
typedef struct canvas {
    int width, height;
    unsigned char *pixel; /* [height][width][3] */
} canvas;

static const unsigned char grey[3] = {96, 96, 96}, paper[3] = {255, 255, 255}, ink[3] = {0, 0, 0};

/* viridis (van der Walt & Smith 2015, CC0) at eighths, sRGB; linear between. */
static void colour_of(double value, unsigned char rgb[3])
{
    static const unsigned char stop[][3] = {{68, 1, 84},    {71, 44, 122},  {59, 82, 139},
                                            {44, 113, 142}, {33, 145, 140}, {40, 174, 128},
                                            {94, 201, 98},  {173, 220, 48}, {253, 231, 37}};
    double place = 8 * fmin(fmax(value, 0), 1);
    int below = (int)fmin(place, 7);
    for (int k = 0; k < 3; k++)
        rgb[k] =
            (unsigned char)(stop[below][k] + (place - below) * (stop[below + 1][k] - stop[below][k]) + 0.5);
}

/* What a pixel shows of the surface in it; NaN where there is none. */
static double value_of(const hpr_image *image, size_t pixel)
{
    size_t n = image->channel_count;
    const float *h = image->layer[HPR_LAYER_IRRADIANCE] + n * pixel;
    double coverage = (double)image->coverage[pixel], sum = 0;
    if (!(coverage > 0))
        return NAN;
    if (n == 3)
        return (0.2126 * (double)h[0] + 0.7152 * (double)h[1] + 0.0722 * (double)h[2]) / coverage;
    for (size_t c = 0; c < n; c++)
        sum += (double)h[c];
    return sum / (double)n / coverage;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The next of 1, 2, 5 times a power of ten that is at least `value`; 1 if that is not above 0. */
static double round_up(double value)
{
    if (!(value > 0) || !isfinite(value))
        return 1;
    double power = pow(10, floor(log10(value)));
    static const double step[] = {1, 2, 5, 10};
    for (int i = 0; i < 4; i++) {
        if (step[i] * power >= value * (1 - 1e-12))
            return step[i] * power;
    }
    return 20 * power; /* log10 was rounded down */
}

static hpr_status choose_top(hpr_context *ctx, const hpr_image *image, double *top)
{
    size_t pixels = (size_t)image->width * (size_t)image->height, count = 0;
    double *value = NULL;
    hpr_status status = hpr_allocate_into(ctx, &value, pixels, sizeof *value, "false colours");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < pixels; i++) {
        double v = value_of(image, i);
        if (isfinite(v))
            value[count++] = v;
    }
    qsort(value, count, sizeof *value, compare);
    *top = round_up(count ? value[(size_t)(0.99 * (double)(count - 1))] : 0);
    hpr_release(ctx, value);
    return HPR_OK;
}

static void fill(canvas *c, int left, int top, int width, int height, const unsigned char rgb[3])
{
    for (int y = top < 0 ? 0 : top; y < top + height && y < c->height; y++) {
        for (int x = left < 0 ? 0 : left; x < left + width && x < c->width; x++)
            memcpy(c->pixel + 3 * ((size_t)y * (size_t)c->width + (size_t)x), rgb, 3);
    }
}

static void write_text(canvas *c, int left, int top, int dot, const char *text)
{
    for (; *text; text++, left += HPR_GLYPH_ADVANCE * dot) {
        const unsigned char *rows = hpr_glyph(*text);
        for (int y = 0; y < HPR_GLYPH_HEIGHT; y++) {
            for (int x = 0; x < HPR_GLYPH_WIDTH; x++) {
                if (rows[y] >> (HPR_GLYPH_WIDTH - 1 - x) & 1)
                    fill(c, left + dot * x, top + dot * y, dot, dot, ink);
            }
        }
    }
}

enum { LEGEND_DOTS = 70, LEAST_HEIGHT = 60, STEPS = 5 };

/* A bar from 0 below to `top` above, five values beside it and the unit over it. dot: pixels per dot */
static void draw_legend(canvas *c, int left, int dot, double top)
{
    int first = 14 * dot, last = c->height - 6 * dot, bar = 12 * dot;
    write_text(c, left + 4 * dot, 3 * dot, dot, "W/m^");
    for (int y = first; y < last; y++) {
        unsigned char rgb[3];
        colour_of((double)(last - 1 - y) / (last - 1 - first), rgb);
        fill(c, left + 4 * dot, y, bar, 1, rgb);
    }
    for (int i = 0; i < STEPS; i++) {
        char text[16];
        int y = last - 1 - (last - 1 - first) * i / (STEPS - 1);
        snprintf(text, sizeof text, "%.4g", top * i / (STEPS - 1));
        fill(c, left + 4 * dot + bar, y, 2 * dot, 1, ink);
        write_text(c, left + 8 * dot + bar, y - HPR_GLYPH_HEIGHT * dot / 2, dot, text);
    }
}

static void draw(canvas *c, const hpr_image *image, int dot, double top)
{
    fill(c, 0, 0, c->width, c->height, paper);
    for (int y = 0; y < image->height; y++) {
        for (int x = 0; x < image->width; x++) {
            unsigned char rgb[3];
            double value = value_of(image, (size_t)y * (size_t)image->width + (size_t)x);
            if (isnan(value))
                memcpy(rgb, grey, sizeof rgb);
            else
                colour_of(value / top, rgb);
            fill(c, x, y, 1, 1, rgb);
        }
    }
    draw_legend(c, image->width, dot, top);
}

hpr_status hpr_image_write_false_colour(hpr_context *ctx, const hpr_image *image, double top,
                                        const char *path, double *used)
{
    hpr_context_clear_error(ctx);
    if (image->width < 1 || image->height < 1 || !image->coverage || !image->layer[HPR_LAYER_IRRADIANCE])
        return hpr_fail(ctx, HPR_ERR_ARG, "'%s': a picture without irradiance has no false colours", path);
    if (!(top >= 0) || !isfinite(top))
        return hpr_fail(ctx, HPR_ERR_ARG, "the legend's top must be finite and >= 0 W/m2, not %g", top);
    hpr_status status = top == 0 ? choose_top(ctx, image, &top) : HPR_OK;
    if (status != HPR_OK)
        return status;
    int dot = image->height / 240 > 0 ? image->height / 240 : 1;
    canvas c = {.width = image->width + LEGEND_DOTS * dot,
                .height = image->height > LEAST_HEIGHT ? image->height : LEAST_HEIGHT};
    hpr_atomic_file file;
    status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &c.pixel, (size_t)c.width * (size_t)c.height, 3, "false colours");
    if (status == HPR_OK) {
        draw(&c, image, dot, top);
        status = hpr_png_encode(&file, c.width, c.height, HPR_PNG_COLOUR, c.pixel);
    }
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    hpr_release(ctx, c.pixel);
    if (status == HPR_OK && used)
        *used = top;
    return status;
}
