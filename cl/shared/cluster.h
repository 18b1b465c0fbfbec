// cluster.h - clusters: consecutive particles that frames keep or cull together (METHOD section 4).
#ifndef SIMULI_CL_SHARED_CLUSTER_H
#define SIMULI_CL_SHARED_CLUSTER_H

// Particles per cluster; a multiple of all lane counts, so that no vector spans two clusters.
#define SIM_CLUSTER 256

// Rows of cluster bounds, one real per cluster each. The ball contains all means, in the axes of their
// parameters.
#define SIM_C_CENTRE 0
#define SIM_C_RADIUS 3
#define SIM_C_LOG_SCALE 4  // the largest
#define SIM_C_OPACITY 5    // the largest logit
#define SIM_C_FROM 6       // smallest and largest level of detail (SIM_DETAIL_.. of layout.h)
#define SIM_C_UNTIL 7
#define SIM_CLUSTER_ROWS 8

#endif
