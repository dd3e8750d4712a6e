/*
 * Triangles that share vertex 0: Sauter & Schwab 2011, sec. 5.2.4,
 *   ∫ xi^3 eta2 [k(xi (1, eta1), xi eta2 (1, eta3)) + k(xi eta2 (1, eta3), xi (1, eta1))] d xi d eta1..3.
 * xi only scales, so the kernel is evaluated at xi = 1 and xi^3 becomes xi.
 */
#include "quadrature/touching.h"

typedef struct vertex_rule {
    const hpr_gauss_rule *gauss;
    const hpr_rule *rule;
} vertex_rule;

/* The points xi (1, eta1): the leading side. */
static void lead(const vertex_rule *v, const hpr_wing *wing, double xi, hpr_points *points)
{
    points->count = 0;
    for (int i = 0; i < v->rule->kernel_nodes; i++) {
        double eta1 = v->gauss->node[i];
        hpr_vec3 position = hpr_madd(wing->first, eta1, wing->second);
        double height = wing->first_height + eta1 * wing->second_height;
        hpr_wing_append(wing, points, xi, xi * eta1, position, v->gauss->weight[i] * height);
    }
}

/* The points xi eta2 (1, eta3): the following side. */
static void follow(const vertex_rule *v, const hpr_wing *wing, double xi, hpr_points *points)
{
    points->count = 0;
    for (int j = 0; j < v->rule->kernel_nodes; j++) {
        double eta2 = v->gauss->node[j];
        for (int i = 0; i < v->rule->kernel_nodes; i++) {
            double eta3 = v->gauss->node[i];
            hpr_vec3 position = hpr_scale(hpr_madd(wing->first, eta3, wing->second), eta2);
            double height = eta2 * (wing->first_height + eta3 * wing->second_height);
            hpr_wing_append(wing, points, xi * eta2, xi * eta2 * eta3, position,
                            v->gauss->weight[j] * v->gauss->weight[i] * eta2 * height);
        }
    }
}

void hpr_points_vertex(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                       hpr_group *group, hpr_group_sink sink, void *user)
{
    hpr_wing recv = hpr_wing_make(&pair->recv, &pair->recv_height, &rule->recv);
    hpr_wing send = hpr_wing_make(&pair->send, &pair->send_height, &rule->send);
    vertex_rule v = {&gauss->legendre[rule->kernel_nodes], rule};
    const hpr_gauss_rule *scale = &gauss->legendre[rule->scale_nodes];
    for (int i = 0; i < rule->scale_nodes; i++) {
        double xi = scale->node[i];
        group->scale = scale->weight[i] * xi;
        if (rule->term == 0) {
            lead(&v, &recv, xi, &group->recv);
            follow(&v, &send, xi, &group->send);
        } else {
            follow(&v, &recv, xi, &group->recv);
            lead(&v, &send, xi, &group->send);
        }
        sink(user, group);
    }
}
