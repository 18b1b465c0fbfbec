#ifndef SIMULI_H
#define SIMULI_H
/* The main calls for C and for languages with C bindings. No call throws: a call that can fail returns a
 * simuli_status, and simuli_error() returns the message. Handles are opaque; close functions accept NULL.
 * Only one thread at a time may use a device and its scenes and frames. Metres, seconds, radians;
 * right-handed frames: world z up; LiDARs x forward, y left, z up; cameras x right, y down, z forward. */
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum simuli_status { /* also the exit codes of the program */
                             SIMULI_OK = 0,
                             SIMULI_USAGE = 2,  /* an argument that is not allowed */
                             SIMULI_INPUT = 3,  /* a missing or invalid file */
                             SIMULI_DEVICE = 4, /* an unknown or failed OpenCL device */
                             SIMULI_KERNEL = 5,
                             SIMULI_NUMERIC = 6,
                             SIMULI_NOTHING = 8, /* no recorded data remain after an import */
                             SIMULI_INTERNAL = 70,
                             SIMULI_MEMORY = 71 /* out of host memory; device memory: SIMULI_DEVICE */
} simuli_status;

typedef struct simuli_device simuli_device;
typedef struct simuli_scene simuli_scene;
typedef struct simuli_frame simuli_frame;

/* Options: a quality ("draft", "balanced", "exact", "reference"; NULL: balanced) and "key=value"
 * settings, listed by `simuli train --set help`. NULL options select balanced. */
typedef struct simuli_options {
  const char* quality;
  const char* const* settings;
  size_t setting_count;
} simuli_options;

/* p_a = rotate(rotation_wxyz, p_b) + position_m; any nonzero quaternion. */
typedef struct simuli_pose {
  double position_m[3];
  double rotation_wxyz[4];
} simuli_pose;

/* Poses and times of a sensor at the start and the end of one frame. */
typedef struct simuli_shot {
  simuli_pose world_from_sensor_start;
  simuli_pose world_from_sensor_end;
  double time_start_s; /* time of the scene's log */
  double time_end_s;   /* equal to the start for a camera with a global shutter */
} simuli_shot;

/* Returns "0.1.0". */
const char* simuli_version(void);
/* Returns the message of the last failed call of this thread, one line; "" without a failed call. */
const char* simuli_error(void);

/* request: part of "platform / device", or the index; NULL or "": the first usable device. For an own context
 * and queue see simuli_device_adopt() of <simuli/opencl.h>. */
simuli_status simuli_device_open(const char* request, simuli_device** device);
const char* simuli_device_name(const simuli_device* device);
void simuli_device_close(simuli_device* device);

/* ---- Training and evaluation ---- */

/* Called after each iteration; a nonzero result ends the training with SIMULI_USAGE. */
typedef int (*simuli_progress)(int iteration, double psnr_db, void* user);

typedef struct simuli_training {
  int iterations;
  double psnr_db;    /* of about the last 20 training pictures */
  double distance_m; /* mean error of the last sweeps */
  size_t camera_particles;
  size_t lidar_particles;
  double seconds;
} simuli_training;

/* Equals `simuli train LOG -o SCENE`, bit for bit. progress and result may be NULL. Returns SIMULI_INPUT before
 * reading any file if `scene` exists: nothing is replaced. */
simuli_status simuli_train(const simuli_device* device,
                           const char* log,
                           const char* scene,
                           const simuli_options* options,
                           simuli_progress progress,
                           void* user,
                           simuli_training* result);

/* Means over the compared frames; NaN without frames. */
typedef struct simuli_evaluation {
  size_t images;
  size_t sweeps;
  int is_held_out; /* training read none of the frames */
  double psnr_db;
  double ssim;
  double distance_median_m;
  double intensity_rmse;
  double raydrop_accuracy;
  double chamfer_m;
  double raydrop_trivial; /* the accuracy of "every ray returns" */
  double drop_recall;     /* share of dropped rays that were predicted; NaN: none dropped */
  double drop_precision;  /* share of predicted drops that were drops; NaN: none predicted */
} simuli_evaluation;

/* Equals `simuli eval SCENE LOG`. The settings may also contain image_scale, held_out_every, held_out_middle
 * and held_out_last: only held_out_every=5 compares every fifth frame, only held_out_last=0.2 the end of the
 * trajectory, only held_out_middle=0.2 a part around its middle. */
simuli_status simuli_evaluate(const simuli_device* device,
                              const char* scene,
                              const char* log,
                              const simuli_options* options,
                              simuli_evaluation* result);

/* ---- Scenes and their sensors ---- */

/* Reads a scene folder or a splat file. The scene retains its device, which may be closed at once. */
simuli_status simuli_scene_open(const simuli_device* device, const char* folder, simuli_scene** scene);
/* Writes the scene with all edits and the original sensors of its log. */
simuli_status simuli_scene_save(const simuli_scene* scene, const char* folder);
void simuli_scene_close(simuli_scene* scene);
/* Returns the number of particles with NaN, Inf or a zero quaternion that a splat file contained. */
size_t simuli_scene_left_out(const simuli_scene* scene);
/* Returns notes on a splat file, one per line: omitted data and the file's statements on its training. "" for
 * other scenes; valid as long as the scene. */
const char* simuli_scene_notes(const simuli_scene* scene);
/* Sets the options of all later frames. */
simuli_status simuli_scene_set_options(simuli_scene* scene, const simuli_options* options);

typedef struct simuli_sensor {
  const char* name; /* valid as long as the scene */
  int is_camera;    /* 0: a LiDAR */
  size_t columns;   /* pixels, or rays per beam */
  size_t rows;      /* pixels, or beams */
  simuli_pose rig_from_sensor;
  double duration_s; /* of a frame */
} simuli_sensor;

/* Sensors of the training and added sensors: index 0 to count - 1. */
size_t simuli_scene_sensor_count(const simuli_scene* scene);
simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor);
/* Adds a built-in camera or LiDAR ("hesai_pandar128", "hesai_xt32@20") or the sensor of a sensor file to
 * the scene. as: new name; NULL: unchanged. */
simuli_status simuli_scene_add_sensor(simuli_scene* scene,
                                      const char* name_or_file,
                                      const char* as,
                                      const simuli_pose* rig_from_sensor);

typedef struct simuli_camera {
  const char* name;
  const char* lens;              /* "pinhole", "opencv_fisheye", ...; NULL: pinhole */
  const double* lens_parameters; /* parameters of the lens, in the order of sensor files */
  size_t lens_parameter_count;
  int width, height;     /* pixels */
  double fx, fy, cx, cy; /* pixels; the centre of the first pixel is (0.5, 0.5) */
  const char* shutter;   /* "global", "top_to_bottom", ...; NULL: global */
  double duration_s;     /* readout time of a rolling shutter */
} simuli_camera;
simuli_status simuli_scene_add_camera(simuli_scene* scene,
                                      const simuli_camera* camera,
                                      const simuli_pose* rig_from_camera);

typedef struct simuli_lidar_row {
  double elevation;         /* rad */
  double azimuth_offset;    /* rad */
  double vertical_offset;   /* m */
  double horizontal_offset; /* m */
  double radial_offset;     /* m */
  double time_offset;       /* s */
} simuli_lidar_row;
typedef struct simuli_lidar {
  const char* name;
  const simuli_lidar_row* rows; /* top to bottom */
  size_t row_count;
  int columns;
  double azimuth_first; /* rad, of column 0 */
  double azimuth_span;  /* rad, of all columns */
  int is_clockwise;
  double sweep_s;
  double range_min, range_max; /* m */
  double beam_divergence;      /* rad, full angle; 0: ideal rays */
} simuli_lidar;
simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const simuli_lidar* lidar,
                                     const simuli_pose* rig_from_lidar);

/* First and last time of the recorded trajectory. */
simuli_status simuli_scene_span(const simuli_scene* scene, double* start_s, double* end_s);
/* Returns the shot of sensor `name` on the recorded trajectory from time_start_s to time_end_s. */
simuli_status simuli_scene_shot(
    const simuli_scene* scene, const char* name, double time_start_s, double time_end_s, simuli_shot* shot);

/* ---- Actors ---- */

typedef struct simuli_actor {
  const char* name; /* name and kind are valid until the scene is edited */
  const char* kind;
  double size_m[3]; /* length, width, height */
  size_t pose_count;
} simuli_actor;
size_t simuli_scene_actor_count(const simuli_scene* scene);
simuli_status simuli_scene_actor(const simuli_scene* scene, size_t index, simuli_actor* actor);
/* Returns the track. `count`: length of both arrays, the actor's pose_count. */
simuli_status simuli_scene_actor_track(
    const simuli_scene* scene, size_t index, double* times_s, simuli_pose* world_from_actor, size_t count);

typedef enum simuli_edit_kind {
  SIMULI_REMOVE = 0,
  SIMULI_MOVE = 1,    /* by_m in the actor's frame (forward, left, up), for the complete track */
  SIMULI_RETIME = 2,  /* rate times as fast, delay_s later */
  SIMULI_RETRACK = 3, /* uses the track times_s, world_from_actor, pose_count */
  SIMULI_DUPLICATE = 4, /* adds a copy named new_name; not for a single frame */
  SIMULI_TURN = 5       /* by yaw_rad to the left about the actor's up axis, for the complete track */
} simuli_edit_kind;
typedef struct simuli_edit {
  simuli_edit_kind kind;
  const char* actor;
  double by_m[3];
  double rate;
  double delay_s;
  const double* times_s;
  const simuli_pose* world_from_actor;
  size_t pose_count;
  const char* new_name;
  double yaw_rad;
} simuli_edit;
/* Applies to all later frames. */
simuli_status simuli_scene_edit(simuli_scene* scene, const simuli_edit* edit);
/* Adds an actor of another scene with its particles and track. */
simuli_status simuli_scene_add_actor(simuli_scene* scene,
                                     const simuli_scene* other,
                                     const char* actor,
                                     const char* new_name);

/* ---- Frames ---- */

/* Additional options of a frame. All zeros: none. */
typedef struct simuli_request {
  const simuli_edit* edits; /* only for this frame, applied in order */
  size_t edit_count;
  const unsigned char* rays; /* [rows][columns]; nonzero: render the ray. Other rays have the background;
                               LiDAR rays have no return. NULL: all rays */
  size_t ray_count;          /* of `rays` */
  int is_ungraded;           /* render without the bilateral grids; gradients require this */
  int with_actors;           /* for SIMULI_ACTORS, labels and flow; needs a second rendering */
} simuli_request;

/* Queues a frame and returns; any number of frames may be queued. request may be NULL. */
simuli_status simuli_render(simuli_scene* scene,
                            const char* name,
                            const simuli_shot* shot,
                            const simuli_request* request,
                            simuli_frame** frame);
void simuli_frame_close(simuli_frame* frame);
simuli_status simuli_frame_is_ready(const simuli_frame* frame, int* is_ready);
simuli_status simuli_frame_wait(const simuli_frame* frame);
/* Starts the transfer of the results to the host. */
simuli_status simuli_frame_fetch(const simuli_frame* frame);

typedef enum simuli_quantity {
  SIMULI_RGB = 0,           /* cameras: 3 values per pixel in [0, 1] */
  SIMULI_FEATURE = 1,       /* 3 values per ray, as blended: colour, or intensity, hit logit, drop logit */
  SIMULI_OPACITY = 2,       /* 1 value per ray from here on: 1 - transmittance */
  SIMULI_DISTANCE = 3,      /* m, expected distance of the ray's light; 0: no particle on the ray */
  SIMULI_MEDIAN = 4,        /* m, distance of transmittance 1/2; 0: not reached */
  SIMULI_RANGE = 5,         /* LiDARs: m from the ray's origin; 0: no return */
  SIMULI_INTENSITY = 6,     /* LiDARs: [0, 1] */
  SIMULI_DROP = 7,          /* LiDARs: probability of ray drop */
  SIMULI_TRANSMITTANCE = 8, /* with SIMULI_FEATURE and the next: inputs of gradients */
  SIMULI_DISTANCE_SUM = 9,  /* sum of w tau, m */
  SIMULI_ACTORS = 10        /* 1 + index of the visible actor; 0: none */
} simuli_quantity;
/* Returns [rows][columns] or [rows][columns][3]. count: length of `values`; SIMULI_USAGE for a wrong length.
 * Waits. */
simuli_status simuli_frame_values(const simuli_frame* frame,
                                  simuli_quantity quantity,
                                  float* values,
                                  size_t count);
/* Returns the points of a LiDAR, [rays][3], world, m; rays without a return have their origin. */
simuli_status simuli_frame_points(const simuli_frame* frame, double* xyz, size_t count);

/* Returns the support of a frame's rays, [rows][columns], from 0 (in no recorded frame) to 1: the share of
 * comparable pixels within 0.05 of the truth, or of comparable LiDAR rays within 2 cm or correctly without a
 * return. SIMULI_USAGE for a scene without support data (an old version, or not trained). Waits. */
simuli_status simuli_frame_support(simuli_scene* scene, const simuli_frame* frame, float* values, size_t count);

/* Ground truth of an actor in a frame: docs/RENDERS.md, "Labels". */
typedef struct simuli_label {
  size_t actor;     /* index of the actor */
  double time_s;    /* time at which the sensor measures the box centre; time of the poses */
  double size_m[3]; /* length, width, height */
  simuli_pose world_from_actor, rig_from_actor, sensor_from_actor;
  size_t rays;            /* number of the actor's pixels or returns */
  double occlusion;       /* NaN: no ray even without occlusion */
  double truncation;      /* this and the following: only cameras */
  double projected_px[4]; /* left, top, right, bottom of the box within the picture; NaN: outside */
  double visible_px[4];   /* bounds of the actor's pixels; NaN: none */
} simuli_label;
/* Returns the labels of a frame that was rendered with_actors. room: length of `labels`, at least
 * simuli_scene_actor_count(); count: number of labels. Waits. */
simuli_status simuli_frame_labels(
    simuli_scene* scene, const simuli_frame* frame, simuli_label* labels, size_t room, size_t* count);
/* Returns flow, [rows][columns][3] each; either may be NULL. pixels: px to the right and down to the same
 * point in the frame `to`, and 1 (zeros: not visible). points: motion of the point in camera axes, m. Needs a
 * camera frame that was rendered with_actors. Waits. */
simuli_status simuli_frame_flow(const simuli_scene* scene,
                                const simuli_frame* frame,
                                const simuli_frame* to,
                                float* pixels,
                                float* points,
                                size_t count);

/* ---- Particles and gradients ---- */

/* Returns values[columns][rows], a column per parameter: mean, log scale, rotation w x y z, opacity logit, SH
 * coefficients. `values` may be NULL: then the call only returns rows and columns. */
simuli_status simuli_scene_particles(
    const simuli_scene* scene, int is_lidar, size_t* rows, size_t* columns, float* values, size_t count);
/* Sets the parameters. The number of particles must not change if some belong to actors. */
simuli_status simuli_scene_set_particles(
    simuli_scene* scene, int is_lidar, size_t rows, const float* values, size_t count);
/* Returns dL/d(particles) of the set of the frame's sensor, in the order of simuli_scene_particles(), from
 * the derivatives of a loss L by FEATURE, TRANSMITTANCE and DISTANCE_SUM of each ray (NULL: 0). Needs a
 * picture without bilateral grids. */
simuli_status simuli_frame_gradients(simuli_scene* scene,
                                     const simuli_frame* frame,
                                     const float* feature,
                                     const float* transmittance,
                                     const float* distance_sum,
                                     float* values,
                                     size_t count);

#ifdef __cplusplus
}
#endif
#endif
