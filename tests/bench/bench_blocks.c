/*
 * What kernel blocks cost, per regime and degree: one JSON object per line on stdout, with the CPU seconds of
 * a block, its error relative to its largest entry, and the kernel evaluations it took. Of several pairs in
 * one case the slowest and the worst count. Compared with is the same block at 1e-14, the other way round.
 */
#include "blocks.h"
#include "shapes.h"

#include <time.h>

#define PI 3.14159265358979323846

enum { VALUES_MAX = HPR_MAX_BASIS * HPR_MAX_BASIS, REPEATS = 5 };

static double block[VALUES_MAX], exact[VALUES_MAX];

typedef struct measured {
    double seconds, error;
    uint64_t kernel_count;
} measured;

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Seconds of one call, over enough calls to be told from the clock's own. */
static double time_once(const hpr_element_frame *recv, const hpr_element_frame *send, double tolerance)
{
    static const double enough = 4e-3;
    double start = cpu_seconds(), spent = 0;
    int calls = 0;
    for (int more = 1; spent < enough; more *= 2) {
        for (int i = 0; i < more; i++)
            block_of(recv, send, tolerance, block);
        calls += more;
        spent = cpu_seconds() - start;
    }
    return spent / calls;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double error_of(const hpr_element_frame *recv, const hpr_element_frame *send)
{
    size_t n = frame_basis(recv), m = frame_basis(send);
    double most = 0, off = 0;
    block_of(send, recv, 1e-14, exact);
    for (size_t k = 0; k < n; k++) {
        for (size_t l = 0; l < m; l++) {
            most = fmax(most, fabs(exact[l * n + k]));
            off = fmax(off, fabs(block[k * m + l] - exact[l * n + k]));
        }
    }
    return off / most;
}

static measured measure(const hpr_element_frame *recv, const hpr_element_frame *send, double tolerance)
{
    double seconds[REPEATS];
    measured m = {.kernel_count = block_of(recv, send, tolerance, block).kernel_count};
    m.error = error_of(recv, send);
    for (int i = 0; i < REPEATS; i++)
        seconds[i] = time_once(recv, send, tolerance);
    qsort(seconds, REPEATS, sizeof *seconds, compare);
    m.seconds = seconds[REPEATS / 2];
    return m;
}

static void worst(measured *all, measured one)
{
    all->error = fmax(all->error, one.error);
    if (one.seconds > all->seconds) {
        all->seconds = one.seconds;
        all->kernel_count = one.kernel_count;
    }
}

static hpr_element_frame unit(hpr_shape shape, int degree)
{
    return frame_of(shape, degree, (double[]){0, 0, 0}, (double[]){1, 0, 0}, (double[]){0, 1, 0});
}

/* On the x axis with the other, this angle between them. */
static hpr_element_frame hinged(hpr_shape shape, int degree, double angle)
{
    double y = cos(angle), z = sin(angle);
    return frame_of(shape, degree, (double[]){1, 0, 0}, (double[]){0, 0, 0}, (double[]){1, y, z});
}

static hpr_element_frame facing(hpr_shape shape, int degree, const double offset[3])
{
    const double *o = offset;
    return frame_of(shape, degree, o, (double[]){o[0], o[1] + 1, o[2]}, (double[]){o[0] + 1, o[1], o[2]});
}

static void tell(const char *name, hpr_shape shape, int degree, double tolerance, measured m)
{
    printf("{\"case\": \"%s %s, degree %d, %.0e\", \"cpu_seconds\": %.6g, \"error\": %.3g, "
           "\"kernel_evaluations\": %llu}\n",
           shape == HPR_SHAPE_TRIANGLE ? "triangles" : "squares", name, degree, tolerance, m.seconds, m.error,
           (unsigned long long)m.kernel_count);
    fflush(stdout);
}

static void edges(hpr_shape shape, int degree)
{
    static const double degrees[] = {5, 30, 60, 90, 150}, tolerance = 1e-12;
    measured all = {0};
    hpr_element_frame floor = unit(shape, degree);
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
        hpr_element_frame wall = hinged(shape, degree, degrees[i] * PI / 180);
        worst(&all, measure(&floor, &wall, tolerance));
    }
    tell("on an edge, 5 to 150 degrees", shape, degree, tolerance, all);
}

static void apart(const char *name, hpr_shape shape, int degree, double tolerance, const double offset[3])
{
    hpr_element_frame floor = unit(shape, degree), other = facing(shape, degree, offset);
    tell(name, shape, degree, tolerance, measure(&floor, &other, tolerance));
}

int main(void)
{
    static const hpr_shape shapes[] = {HPR_SHAPE_PARALLELOGRAM, HPR_SHAPE_TRIANGLE};
    if (bench_open(NULL))
        return 1;
    for (int i = 0; i < 2; i++) {
        for (int degree = 0; degree <= 3; degree += 3) {
            edges(shapes[i], degree);
            apart("at gap 0.1", shapes[i], degree, 1e-12, (double[]){0, 0, 0.1});
            apart("at gap 1", shapes[i], degree, 1e-12, (double[]){0.25, 0, 1});
            apart("4 sizes apart", shapes[i], degree, 1e-10, (double[]){2, 1.5, 3.1225});
        }
    }
    apart("at gap 1", HPR_SHAPE_PARALLELOGRAM, 8, 1e-12, (double[]){0.25, 0, 1});
    bench_close(NULL);
    return 0;
}
