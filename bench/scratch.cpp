#include "ndg/core/error.h"
#include "ndg/core/log.h"

#include "ndg/core/tool.h"
#include "ndg/core/stopwatch.h"
#include "ndg/body/pose_set.h"
#include "ndg/motion/clinical_angles.h"
#include "ndg/simulation/simulator.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/prism.h"
using namespace ndg;
int main(int argc,char**argv){
  const std::string D="/tmp/w/data/";
  Template t=read_template(D+"template-male.h5");
  auto bodies=read_bodies(D+"bodies-male-old.h5",t);
  auto poses=read_poses(D+"poses-male.h5");
  fmt::print("bodies {} poses {} prisms {} wraptri {}\n",bodies.bodies.size(),poses.size(),t.num_prisms(),t.wrap_triangles.rows());
  SimulationOptions o; o.newton.max_iterations=120; if(argc>1&&std::string(argv[1])=="g") o.material.energy=FleshEnergy::inversion_free;
  Simulator sim(t,o); SimulationOptions oc=o; oc.contact.contact=argc>2; Simulator simc(t,oc); if(argc>2) set_log_level(LogLevel::debug);
  BodyPoser poser(t);
  int n=t.num_wrap_vertices();
  ClinicalFrames frames(t.rest.joint_positions);
  std::vector<std::pair<double,int>> order;
  for(int p=0;p<poses.size();++p){auto a=frames.angles(poses.poses[p]); order.push_back({-std::min(a[find_clinical_angle("left_knee.flexion")],a[find_clinical_angle("right_knee.flexion")]),p});}
  std::sort(order.begin(),order.end());
  std::vector<int> pick; for(int i=0;i<4;++i) pick.push_back(order[i*3].second); for(int i=0;i<8;++i) pick.push_back((i*37)%poses.size());
  for(int b:{argc>4?atoi(argv[4]):0}) { const Body& body= b==0? t.rest: bodies.bodies[b]; sim.set_body(body); simc.set_body(body);
   double c0=thread_seconds(); auto r0=crossing_triangles(body.volume_vertices.bottomRows(n),t.wrap_triangles); double c1=thread_seconds();
   fmt::print("body {} rest crossing {} ({:.1f} ms) bone {}\n",b,r0.size(),1e3*(c1-c0),crossing_triangles(body.volume_vertices.topRows(n),t.wrap_triangles).size());
   for(int p:pick){ if(argc>3&&p!=atoi(argv[3])) continue;
    auto a=frames.angles(poses.poses[p]);
    PosedBody posed=poser.pose(body,poses.poses[p]);
    Points gs=sim.start(poses.poses[p]);
    double s0=thread_seconds(); auto r=sim.simulate(poses.poses[p]); double s1=thread_seconds(); auto rc=argc<3?r:simc.simulate(poses.poses[p]); double s2=thread_seconds();
    auto invc=count_inverted_prisms(rc.vertices,t.prisms);
    fmt::print("   contact: {:.2f}s {} res {:.1e} it {} (plain {}) crossing {}; inv {} corner {}\n",s2-s1,describe(rc.newton.stop),rc.newton.residual_relative,rc.newton.iterations,r.newton.iterations,rc.intersecting_triangles,invc.by_volume,invc.at_corners); fflush(stdout);
    auto cnt=[&](const Points& x){return triangles_of_pairs(crossing_triangles(x,t.wrap_triangles)).size();};
    auto inv=count_inverted_prisms(r.vertices,t.prisms); auto ig=count_inverted_prisms(gs,t.prisms);
    fmt::print("pose {:4d} {:<24} knee {:4.0f}: {:.2f}s conv {} crossing tris: bone {} lbs-skin {} gs {} fem {}; inv {} corner {} (gs {} {})\n",p,poses.clip_names[poses.clip_idx[p]],57.3*a[find_clinical_angle("left_knee.flexion")],s1-s0,r.newton.converged(),cnt(posed.bone_wrap()),cnt(posed.skinned_volume().bottomRows(n)),cnt(gs.bottomRows(n)),cnt(r.vertices.bottomRows(n)),inv.by_volume,inv.at_corners,ig.by_volume,ig.at_corners);
   }}
}
