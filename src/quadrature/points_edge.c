/*
 * Triangles that share the edge from vertex 0 to vertex 1: Sauter & Schwab 2011, sec. 5.2.3,
 *   ∫ xi^3 eta1^2 { k(1, eta1 eta3 | 1 - eta1 eta2, eta1 (1 - eta2))
 *     + eta2 [k(1, eta1 | 1 - eta1 eta2 eta3, eta1 eta2 (1 - eta3)) + k(1 - eta1 eta2, eta1 (1 - eta2) | 1,
 * eta1 eta2 eta3)
 *           + k(1 - eta1 eta2 eta3, eta1 eta2 (1 - eta3) | 1, eta1) + k(1 - eta1 eta2 eta3, eta1 (1 - eta2
 * eta3) | 1, eta1 eta2)] }, every coordinate times xi. Positions are taken relative to the point xi of the
 * edge; there xi eta1 only scales, so the kernel is evaluated at xi eta1 = 1 and xi^3 eta1^2 becomes xi.
 */
#include "quadrature/touching.h"

typedef struct edge_rule {
    const hpr_gauss_rule *gauss;
    const hpr_rule *rule;
    int n; /* kernel nodes */
    hpr_wing recv, send;
    double xi, eta1;
    hpr_group *group;
    hpr_group_sink sink;
    void *user;
} edge_rule;

/* Appends the point xi (1 - eta1 back, eta1 up). */
static void append(const edge_rule *e, const hpr_wing *wing, hpr_points *points, double back, double up,
                   double weight)
{
    hpr_vec3 position = hpr_madd(hpr_scale(e->recv.first, -back), up, wing->second);
    hpr_wing_append(wing, points, e->xi * (1 - e->eta1 * back), e->xi * e->eta1 * up, position,
                    weight * up * wing->second_height);
}

static void clear(edge_rule *e)
{
    e->group->recv.count = 0;
    e->group->send.count = 0;
}

static void flush(edge_rule *e)
{
    e->sink(e->user, e->group);
    clear(e);
}

/* First term: receiver (0, eta3), sender (eta2, 1 - eta2). */
static void both_vary(edge_rule *e)
{
    clear(e);
    for (int i = 0; i < e->n; i++) {
        append(e, &e->recv, &e->group->recv, 0, e->gauss->node[i], e->gauss->weight[i]);
        append(e, &e->send, &e->group->send, e->gauss->node[i], 1 - e->gauss->node[i], e->gauss->weight[i]);
    }
    flush(e);
}

/* Second and fourth term: one side (0, 1), the other (eta2 eta3, eta2 (1 - eta3)). */
static void one_at_tip(edge_rule *e, bool recv_at_tip)
{
    const hpr_wing *tip = recv_at_tip ? &e->recv : &e->send, *other = recv_at_tip ? &e->send : &e->recv;
    hpr_points *tip_points = recv_at_tip ? &e->group->recv : &e->group->send;
    hpr_points *other_points = recv_at_tip ? &e->group->send : &e->group->recv;
    clear(e);
    append(e, tip, tip_points, 0, 1, 1);
    for (int j = 0; j < e->n; j++) {
        double eta2 = e->gauss->node[j];
        for (int i = 0; i < e->n; i++) {
            double eta3 = e->gauss->node[i];
            append(e, other, other_points, eta2 * eta3, eta2 * (1 - eta3),
                   e->gauss->weight[j] * e->gauss->weight[i] * eta2);
        }
    }
    flush(e);
}

/* Third term: receiver (eta2, 1 - eta2), sender (0, eta2 eta3). */
static void sender_on_edge_normal(edge_rule *e)
{
    clear(e);
    for (int j = 0; j < e->n; j++) {
        double eta2 = e->gauss->node[j];
        append(e, &e->recv, &e->group->recv, eta2, 1 - eta2, e->gauss->weight[j] * eta2);
        for (int i = 0; i < e->n; i++)
            append(e, &e->send, &e->group->send, 0, eta2 * e->gauss->node[i], e->gauss->weight[i]);
        flush(e);
    }
}

/* Fifth term: receiver (eta2 eta3, 1 - eta2 eta3), sender (0, eta2). */
static void receiver_on_diagonal(edge_rule *e)
{
    clear(e);
    for (int j = 0; j < e->n; j++) {
        double eta2 = e->gauss->node[j];
        append(e, &e->send, &e->group->send, 0, eta2, e->gauss->weight[j] * eta2);
        for (int i = 0; i < e->n; i++) {
            double product = eta2 * e->gauss->node[i];
            append(e, &e->recv, &e->group->recv, product, 1 - product, e->gauss->weight[i]);
        }
        flush(e);
    }
}

static void add_term(edge_rule *e)
{
    switch (e->rule->term) {
    case 0:
        both_vary(e);
        return;
    case 1:
        one_at_tip(e, true);
        return;
    case 2:
        sender_on_edge_normal(e);
        return;
    case 3:
        one_at_tip(e, false);
        return;
    default:
        receiver_on_diagonal(e);
        return;
    }
}

void hpr_points_edge(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                     hpr_group *group, hpr_group_sink sink, void *user)
{
    edge_rule e = {.gauss = &gauss->legendre[rule->kernel_nodes],
                   .rule = rule,
                   .n = rule->kernel_nodes,
                   .recv = hpr_wing_make(&pair->recv, &pair->recv_height, &rule->recv),
                   .send = hpr_wing_make(&pair->send, &pair->send_height, &rule->send),
                   .group = group,
                   .sink = sink,
                   .user = user};
    const hpr_gauss_rule *scale = &gauss->legendre[rule->scale_nodes];
    for (int i = 0; i < rule->scale_nodes; i++) {
        for (int j = 0; j < rule->scale_nodes; j++) {
            e.xi = scale->node[i];
            e.eta1 = scale->node[j];
            group->scale = scale->weight[i] * scale->weight[j] * e.xi;
            add_term(&e);
        }
    }
}
