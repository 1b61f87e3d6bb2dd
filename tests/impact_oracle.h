// impact_oracle.h: when a vertex and a face, or two edges, first touch, exactly.
//
// The four points are in a plane at the roots of a cubic. Where that is not zero throughout, its roots are
// isolated with Sturm's chain and each is asked whether the features meet there: signs of polynomials at an
// algebraic number, by Tarski's. Where it is zero, so for motion in a plane or on a line, the roots of the
// side tests themselves are asked. All in integers. Shares nothing with the engine.

#ifndef PERCALE_TESTS_IMPACT_ORACLE_H
#define PERCALE_TESTS_IMPACT_ORACLE_H

#include "exact.h"

typedef struct ImpactQuery {
    bool edges; // else vertex, face 0, 1, 2
    double start[4][3];
    double end[4][3];
} ImpactQuery;

/// A time: the only root of the chain's first polynomial between low and high, or low itself when they are
/// the same.
typedef struct ExactTime {
    double low;
    double high;
    Chain chain;
} ExactTime;

enum { EVENTS_MOST = 32 };

typedef struct ImpactTruth {
    int count; // 0: they never touch. Else the first of these is when they first do
    ExactTime times[EVENTS_MOST];
    bool undecided; // roots nearer to each other than doubles can part
} ImpactTruth;

/// The truth's numbers live until the next exact_forget().
void impact_truth(const ImpactQuery *query, ImpactTruth *truth);
/// Sign of (time of the first touch - time).
int impact_truth_order(const ImpactTruth *truth, double time);
/// Time of the first touch, rounded down to 2^-40.
double impact_truth_time(ImpactTruth *truth);

/// Whether they are within the separation at that moment, exactly.
bool impact_within(const ImpactQuery *query, double separation, double time);

/// Their distance then, in long double.
long double impact_distance(const ImpactQuery *query, double time);
/// The least over all times, and when, as far as a search from samples finds it.
double impact_least_distance(const ImpactQuery *query, double *time);
/// Largest difference of coordinates between the two features, and the farthest that one changes.
double impact_size(const ImpactQuery *query);
double impact_way(const ImpactQuery *query);

#endif
