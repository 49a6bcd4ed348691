// Rays of ../shared/bench/c_flake.gml in Embree 3: those from the eye, and those from what they meet
// toward the lamp. Prints one JSON object a kind of geometry. `benches/rays.py` compiles and runs it.

#include <embree3/rtcore.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <vector>
#if defined(__SSE__)
#include <xmmintrin.h>
#include <pmmintrin.h>
#endif

namespace {

constexpr int WIDTH = 800, HEIGHT = 600;
constexpr double FOV_DEG = 75.0;
constexpr float FAR = std::numeric_limits<float>::infinity();
// The plane is a square of this half width; the lowest rays that meet the real one do so at
// z = 2084, with x up to 1600.
constexpr float PLANE_EXTENT = 1e5f;
constexpr double PLANE_Y = -2.0;
// Shadow rays start so far off the surface: a hundred times the rounding of single precision here, and a
// hundredth of the least radius.
constexpr double OFFSET = 1e-4;

struct Vec {
  double x, y, z;
  Vec operator+(Vec b) const { return {x + b.x, y + b.y, z + b.z}; }
  Vec operator-(Vec b) const { return {x - b.x, y - b.y, z - b.z}; }
  Vec operator*(double f) const { return {x * f, y * f, z * f}; }
};

double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Sphere { Vec centre; double radius; };

std::vector<Sphere> spheres;

// Turns two axes of a frame about the third.
void turn(Vec& a, Vec& b, double degrees) {
  double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  Vec turned = a * c + b * s;
  b = b * c - a * s;
  a = turned;
}

// A sphere in a frame of this centre, scale and axes, and smaller ones around it.
void flake(int level, Vec centre, double scale, Vec x, Vec y, Vec z) {
  spheres.push_back({centre, scale});
  auto kid = [=](double about_y, double about_z) {
    Vec kid_x = x, kid_y = y, kid_z = z;
    turn(kid_z, kid_x, about_y);
    turn(kid_x, kid_y, about_z);
    flake(level - 1, centre + kid_y * (scale * 4 / 3), scale / 3, kid_x, kid_y, kid_z);
  };
  if (level == 0) return;
  for (double about_y : {0, 60, 120, 180, 240, 300}) kid(about_y, -90);
  for (double about_y : {30, 150, 270}) kid(about_y, -40);
}

// Where a line enters and leaves a sphere.
bool crossings(const Sphere& sphere, Vec origin, Vec dir, double out[2]) {
  Vec to = sphere.centre - origin;
  double a = dot(dir, dir), middle = dot(to, dir) / a;
  Vec off = to - dir * middle;
  double rest = sphere.radius * sphere.radius - dot(off, off);
  if (rest < 0) return false;
  double half = std::sqrt(rest / a);
  out[0] = middle - half, out[1] = middle + half;
  return true;
}

Vec origin_of(const RTCRay& ray) { return {ray.org_x, ray.org_y, ray.org_z}; }
Vec dir_of(const RTCRay& ray) { return {ray.dir_x, ray.dir_y, ray.dir_z}; }

// The distance of the first crossing that counts; NaN if there is none.
double first(const RTCRay& ray, unsigned index) {
  double at[2];
  if (crossings(spheres[index], origin_of(ray), dir_of(ray), at))
    for (double t : at)
      if (t > ray.tnear && t < ray.tfar) return t;
  return NAN;
}

void sphere_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& [c, r] = spheres[args->primID];
  auto down = [](double x) { return std::nextafter(float(x), -FAR); };
  auto up = [](double x) { return std::nextafter(float(x), FAR); };
  RTCBounds* b = args->bounds_o;
  b->lower_x = down(c.x - r), b->lower_y = down(c.y - r), b->lower_z = down(c.z - r);
  b->upper_x = up(c.x + r), b->upper_y = up(c.y + r), b->upper_z = up(c.z + r);
}

void sphere_intersect(const RTCIntersectFunctionNArguments* args) {
  auto* found = reinterpret_cast<RTCRayHit*>(args->rayhit);
  double t = first(found->ray, args->primID);
  if (!args->valid[0] || std::isnan(t)) return;
  found->ray.tfar = float(t);
  found->hit.geomID = args->geomID, found->hit.primID = args->primID;
}

void sphere_occluded(const RTCOccludedFunctionNArguments* args) {
  auto* ray = reinterpret_cast<RTCRay*>(args->ray);
  if (args->valid[0] && !std::isnan(first(*ray, args->primID))) ray->tfar = -FAR;
}

template <class T>
T* buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t n) {
  return static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), n));
}

// Geometry 0 is the spheres, 1 the plane.
RTCScene build(RTCDevice device, bool is_double) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  auto type = is_double ? RTC_GEOMETRY_TYPE_USER : RTC_GEOMETRY_TYPE_SPHERE_POINT;
  RTCGeometry balls = rtcNewGeometry(device, type);
  if (is_double) {
    rtcSetGeometryUserPrimitiveCount(balls, spheres.size());
    rtcSetGeometryBoundsFunction(
        balls, [](const RTCBoundsFunctionArguments* args) { sphere_bounds(args); }, nullptr);
    rtcSetGeometryIntersectFunction(balls, sphere_intersect);
    rtcSetGeometryOccludedFunction(balls, sphere_occluded);
  } else {
    struct Point { float x, y, z, r; };
    auto* points = buffer<Point>(balls, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, spheres.size());
    for (const auto& [c, r] : spheres) *points++ = {float(c.x), float(c.y), float(c.z), float(r)};
  }
  RTCGeometry plane = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  struct Corner { float x, y, z; };
  struct Quad { unsigned corners[4]; };
  auto* corners = buffer<Corner>(plane, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 4);
  float e = PLANE_EXTENT, y = PLANE_Y;
  corners[0] = {-e, y, -e}, corners[1] = {-e, y, e}, corners[2] = {e, y, e}, corners[3] = {e, y, -e};
  *buffer<Quad>(plane, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4, 1) = {{0, 1, 2, 3}};
  for (RTCGeometry geometry : {balls, plane}) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene);
  return scene;
}

double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

RTCRay ray(Vec origin, Vec dir) {
  return {float(origin.x), float(origin.y), float(origin.z), 0,
          float(dir.x), float(dir.y), float(dir.z), 0, FAR, ~0u, 0, 0};
}

struct Found { unsigned geometry, index; };

void measure(RTCDevice device, bool is_double) {
  double start = now();
  RTCScene scene = build(device, is_double);
  double building = now() - start;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;

  double half = std::tan(FOV_DEG / 2 * M_PI / 180) / WIDTH;
  auto eye_dir = [half](int column, int row) {
    return Vec{(2 * column + 1 - WIDTH) * half, (HEIGHT - 2 * row - 1) * half, 1};
  };
  const Vec eye{0, 0, -1};
  std::vector<Found> found(WIDTH * HEIGHT);
  start = now();
  for (int row = 0; row < HEIGHT; row++)
    for (int column = 0; column < WIDTH; column++) {
      RTCRayHit sought{};
      sought.ray = ray(eye, eye_dir(column, row));
      sought.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene, &context, &sought);
      found[row * WIDTH + column] = {sought.hit.geomID, sought.hit.primID};
    }
  double eye_time = now() - start;

  Vec toward{-0.7, 1.0, -0.8};
  toward = toward * (1 / std::sqrt(dot(toward, toward)));
  long n_spheres = 0, n_plane = 0;
  std::vector<Vec> origins;
  for (int pixel = 0; pixel < WIDTH * HEIGHT; pixel++) {
    auto [geometry, index] = found[pixel];
    Vec dir = eye_dir(pixel % WIDTH, pixel / WIDTH), point, normal{0, 1, 0};
    if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
    if (geometry == 0) {
      n_spheres++;
      // In double precision, and the nearest point where only single precision meets the sphere.
      double at[2];
      const Sphere& sphere = spheres[index];
      if (!crossings(sphere, eye, dir, at)) at[0] = dot(sphere.centre - eye, dir) / dot(dir, dir);
      normal = (eye + dir * at[0] - sphere.centre) * (1 / sphere.radius);
      point = sphere.centre + normal * sphere.radius;
    } else {
      n_plane++;
      point = eye + dir * (PLANE_Y / dir.y);
    }
    if (dot(normal, toward) > 0) origins.push_back(point + normal * OFFSET);
  }
  long n_blocked = 0;
  start = now();
  for (Vec origin : origins) {
    RTCRay sought = ray(origin, toward);
    rtcOccluded1(scene, &context, &sought);
    n_blocked += sought.tfar < 0;
  }
  double shadow_time = now() - start;
  std::printf("{\"geometry\": \"%s\", \"build_s\": %.6f, \"eye_s\": %.6f, \"shadow_s\": %.6f, "
              "\"spheres\": %ld, \"plane\": %ld, \"shadow\": %zu, \"blocked\": %ld}\n",
              is_double ? "doubles" : "points", building, eye_time, shadow_time,
              n_spheres, n_plane, origins.size(), n_blocked);
  rtcReleaseScene(scene);
}

}  // namespace

int main() {
#if defined(__SSE__)
  // As Embree's manual advises.
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
  Vec x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  turn(x, y, 20);
  turn(y, z, -50);
  flake(4, {0, 0.1, 2.6}, 1, x, y, z);
  RTCDevice device = rtcNewDevice("threads=1");
  if (!device) return std::fprintf(stderr, "no Embree device\n"), 1;
  for (bool is_double : {false, true}) measure(device, is_double);
  rtcReleaseDevice(device);
}
