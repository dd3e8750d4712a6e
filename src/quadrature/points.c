#include "quadrature/rule.h"

void hpr_rule_points(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                     hpr_group *group, hpr_group_sink sink, void *user)
{
    switch (rule->kind) {
    case HPR_RULE_PRODUCT:
        hpr_points_product(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_VERTEX:
        hpr_points_vertex(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_EDGE:
        hpr_points_edge(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_NESTED:
        hpr_points_nested(gauss, pair, rule, group, sink, user);
        return;
    }
}

double hpr_group_sum(const hpr_group *group)
{
    const hpr_points *a = &group->recv, *b = &group->send;
    double sum = 0;
    for (int i = 0; i < a->count; i++) {
        double row = 0;
        for (int j = 0; j < b->count; j++) {
            double dx = b->x[j] - a->x[i], dy = b->y[j] - a->y[i], dz = b->z[j] - a->z[i];
            double r2 = dx * dx + dy * dy + dz * dz;
            row += b->weight[j] / (r2 * r2);
        }
        sum += a->weight[i] * row;
    }
    return group->scale * sum / 3.14159265358979323846;
}
