#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"
#include "ndg/body/pose_set.h"
#include "ndg/simulation/simulator.h"
using namespace ndg;
int main(int argc,char**argv){
  const std::string D="/tmp/w/data/";
  Template t=read_template(D+"template-male.h5");
  auto bodies=read_bodies(D+"bodies-male-old.h5",t); auto poses=read_poses(D+"poses-male.h5");
  SimulationOptions o; o.newton.max_iterations=120; if(argc>1&&std::string(argv[1])=="g") o.material.energy=FleshEnergy::inversion_free;
  Simulator sim(t,o); double s=0,it=0,fac=0,inv=0,cor=0,cr=0,relax=0,ev=0,asmb=0,fc=0; int n=0,conv=0,ls=0,clean=0;
  for(int b:{2,9}){ sim.set_body(bodies.bodies[b]);
   for(int p:{8,1060,0,37,74,111,148,222,296,370,444,518}){ double a=thread_seconds(); auto r=sim.simulate(poses.poses[p]); s+=thread_seconds()-a; it+=r.newton.iterations; fac+=r.newton.factorizations; inv+=r.inverted_prisms.by_volume; cor+=r.inverted_prisms.at_corners; clean+=r.inverted_prisms.at_corners==0; cr+=r.intersecting_triangles; conv+=r.newton.converged(); ls+=r.load_steps>0; relax+=r.newton.seconds.relaxation; ev+=r.newton.seconds.evaluation; asmb+=r.newton.seconds.assembly; fc+=r.newton.seconds.factorization; ++n;}}
  fmt::print("n {} s {:.3f} it {:.2f} fac {:.2f} conv {} steps {} inv {:.2f} corner {:.2f} clean {} crossing {:.1f}; relax {:.3f} eval {:.3f} asm {:.3f} fac {:.3f}\n",n,s/n,it/n,fac/n,conv,ls,inv/n,cor/n,clean,cr/n,relax/n,ev/n,asmb/n,fc/n);
}
