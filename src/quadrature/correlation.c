#include "quadrature/correlation.h"

#include <float.h>
#include <math.h>
#include <string.h>

int hpr_overlap_spans(const hpr_overlap *o, hpr_span spans[3])
{
    static const double nothing = 8 * DBL_EPSILON;
    double shorter = fmin(1, o->length), longer = fmax(1, o->length), first = o->first - 1;
    int count = 0;
    spans[count++] = (hpr_span){HPR_OVERLAP_RISES, first, first + shorter};
    if (longer - shorter > nothing * longer)
        spans[count++] = (hpr_span){HPR_OVERLAP_WHOLE, first + shorter, first + longer};
    spans[count] = (hpr_span){HPR_OVERLAP_FALLS, spans[count - 1].high, o->first + o->length};
    return count + 1;
}

/* The common part of both sides where d is `part` of the way through a span. */
typedef struct common {
    double length, recv, send; /* it begins there on the receiver and on the sender */
} common;

static common common_part(const hpr_overlap *o, const hpr_span *s, double part)
{
    double length = s->high - s->low, way = part * length;
    if (s->kind == HPR_OVERLAP_RISES)
        return (common){way, 1 - way, 0};
    if (s->kind == HPR_OVERLAP_FALLS) {
        double left = (1 - part) * length;
        return (common){left, 0, o->length - left};
    }
    return o->length >= 1 ? (common){1, 0, way} : (common){o->length, length - way, 0};
}

void hpr_legendre(double x, int count, double *values)
{
    values[0] = 1;
    if (count > 1)
        values[1] = x;
    for (int n = 1; n + 1 < count; n++)
        values[n + 1] = ((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1);
}

/* c_kl where d is `part` of the way through the span: value[k * n_send + l] */
static void correlation_at(const hpr_gauss_rule *gauss, int nodes, const hpr_overlap *o, const common *part,
                           const hpr_correlation *c, double *value)
{
    double recv[HPR_MAX_DEGREE + 1], send[HPR_MAX_DEGREE + 1];
    memset(value, 0, (size_t)(c->n_recv * c->n_send) * sizeof *value);
    for (int i = 0; i < nodes; i++) {
        double x = part->recv + part->length * gauss->node[i];
        double y = (part->send + part->length * gauss->node[i]) / o->length;
        double weight = gauss->weight[i] * part->length / o->length;
        hpr_legendre(2 * x - 1, c->n_recv, recv);
        hpr_legendre(o->reversed ? 1 - 2 * y : 2 * y - 1, c->n_send, send);
        for (int k = 0; k < c->n_recv; k++) {
            for (int l = 0; l < c->n_send; l++)
                value[k * c->n_send + l] += weight * sqrt((2 * k + 1) * (2 * l + 1)) * recv[k] * send[l];
        }
    }
}

/* Gauss with as many nodes as there are functions is exact along d, with half of them along the common part.
 */
void hpr_correlate(const hpr_gauss_table *gauss, const hpr_overlap *o, const hpr_span *s,
                   const hpr_correlation *c)
{
    double value[HPR_MAX_BASIS], of_d[HPR_CORRELATION_FUNCTIONS];
    const hpr_gauss_rule *outer = &gauss->legendre[c->functions];
    int pairs = c->n_recv * c->n_send, inner_count = c->functions / 2;
    memset(c->coefficient, 0, (size_t)(pairs * c->functions) * sizeof(double));
    for (int j = 0; j < c->functions; j++) {
        common part = common_part(o, s, outer->node[j]);
        correlation_at(&gauss->legendre[inner_count], inner_count, o, &part, c, value);
        hpr_legendre(2 * outer->node[j] - 1, c->functions, of_d);
        for (int a = 0; a < c->functions; a++)
            of_d[a] *= (2 * a + 1) * outer->weight[j];
        for (int kl = 0; kl < pairs; kl++) {
            double *to = c->coefficient + kl * c->functions;
            for (int a = 0; a < c->functions; a++)
                to[a] += value[kl] * of_d[a];
        }
    }
}
