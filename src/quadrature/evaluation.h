/*
 * A block while it is integrated, for those who evaluate the points of its rules: block_ref.c, simple, and
 * block_simd.c, fast.
 */
#ifndef HPR_QUADRATURE_EVALUATION_H
#define HPR_QUADRATURE_EVALUATION_H

#include "quadrature/block.h"
#include "quadrature/products.h"
#include "quadrature/rule.h"
#include "quadrature/sampled.h"

struct hpr_quadrature {
    hpr_context *context;
    const hpr_gauss_table *gauss;
};

/* Sums over points with one side as the outer one: moments of outer points against what stands for the inner
 * polynomials, gathered until a rule ends. */
typedef struct hpr_row_batch {
    size_t count; /* outer points */
    bool used;    /* by this rule */
    double s[HPR_ROWS], t[HPR_ROWS];
    double *moment; /* [inner][outer points], in `room` of the scratch */
    double *sum;    /* [inner][outer functions], there too */
} hpr_row_batch;

struct hpr_block_scratch {
    hpr_context *context;
    hpr_isa isa;
    hpr_group points;
    hpr_rule_scratch choice; /* the choice of rules works here while `points` is being evaluated */
    hpr_moment_scratch moments;
    double transported[HPR_MAX_BASIS]; /* sum over inner points of G phi_l */
    double kernel[HPR_POINTS_ROOM];
    hpr_row_batch batch[2];    /* 1: the receiver is the outer side */
    hpr_moment_map map[2];     /* of the inner side then */
    hpr_factor_tables factors; /* of one side of a product rule */
    hpr_convex blocker[HPR_CLIP_BLOCKERS];
    /* in `room`, what grows with the number of functions; so do arrays of the above */
    double *outer_basis; /* [outer functions][HPR_ROWS] */
    double *moment;      /* [inner functions][HPR_ROWS] */
    double *inside[2];   /* sums that homotheties are to be applied to */
    double *part;        /* what one rule contributes: the block, or `own_part` */
    double *own_part;
    double *matrices;
    _Alignas(hpr_lanes) double room[];
};

typedef struct hpr_evaluation hpr_evaluation;

typedef struct hpr_evaluator {
    void (*begin)(hpr_evaluation *evaluation);
    hpr_group_sink add_group;                     /* user: the evaluation */
    void (*end_rule)(hpr_evaluation *evaluation); /* now all must stand in scratch->part */
} hpr_evaluator;

extern const hpr_evaluator hpr_evaluator_simple, hpr_evaluator_fast;

struct hpr_evaluation {
    const hpr_evaluator *by;
    const hpr_quadrature *quadrature;
    const hpr_block_task *task;
    const hpr_pair *pair;
    double scale; /* from metres to the pair's unit of length */
    size_t n_recv, n_send;
    double *block;
    /* of the block's sum and of those that homotheties are to be applied to: estimated error, and the sum of
     * what the rules contribute at most to an entry */
    double error[3], size[3];
    bool begun[3]; /* something was added to them */
    bool sampled;  /* visibility, by rays */
    bool spent;    /* the budget of evaluations */
    bool complete; /* no rule stopped short */
    hpr_block_scratch *scratch;
    hpr_block_result *result;
    const hpr_rule *rule; /* the one whose points are added */
    hpr_sampled rays;
};

/* One side of a group in the evaluation: `outer` is gone through point by point, all of `inner` for each. */
typedef struct hpr_group_side {
    const hpr_points *points;
    const hpr_element_frame *frame;
    size_t basis_count;
    const hpr_cell *cell; /* of a product rule, with its nodes */
    const int *nodes;
} hpr_group_side;

typedef struct hpr_group_sides {
    hpr_group_side outer, inner;
} hpr_group_sides;

hpr_group_sides hpr_evaluation_sides(const hpr_evaluation *evaluation, const hpr_group *group, bool by_recv);

/* Zeroes the kernel from outer point i to inner ones where the ray is blocked. */
void hpr_evaluation_sample(hpr_evaluation *evaluation, const hpr_group_side *outer, int i,
                           const hpr_group_side *inner, double *kernel);

#endif
