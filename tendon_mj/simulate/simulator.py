"""TEMPORARY stand-in."""
from __future__ import annotations
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Protocol
import mujoco, numpy as np
from tendon_mj.simulate.library import load_model
from tendon_mj.simulate.replay import replay
from tendon_mj.simulate.replay_parameters import Adjustable
class SimulatorLike(Protocol):
    parameters: Any
    units: Any
    free_joints: Any
    def __call__(self, sets: Any) -> Any: ...
class Simulator:
    def __init__(self, recordings, model=None, timestep=None):
        self.recordings=list(recordings)
        self.model = model or load_model(self.recordings[0].model)
        if timestep: self.model.opt.timestep=timestep
        a=Adjustable(self.model)
        r=self.recordings[0]
        from tendon_mj.attach import Parameters
        P=Parameters(self.model, mujoco.MjData(self.model))
        self.parameters={k:float(P[k]) for k in P}
        self.units={}
        for n in a.names():
            if n in self.parameters: continue
            e,p=n.rsplit(".",1)
            if p in ("offset",): self.parameters[n]=0.0
            elif p in ("scale","command_scale"): self.parameters[n]=1.0
            elif p=="command_offset": self.parameters[n]=0.
            elif p in ("damping","stiffness","frictionloss"):
                j=self.model.joint(e); 
                self.parameters[n]=float({"damping":self.model.dof_damping[j.dofadr[0]],"stiffness":self.model.jnt_stiffness[j.id],"frictionloss":self.model.dof_frictionloss[j.dofadr[0]]}[p])
        self.parameters.update(r.known); self.parameters.update({k:u.value for k,u in r.uncertain.items()})
        self.free_joints=[self.model.joint(k).name for k in range(self.model.njnt)]
    def finer(self):
        import copy
        m=copy.copy(self.model); m.opt.timestep/=2
        return Simulator(self.recordings,m)
    def __call__(self, sets):
        jobs=[(s,r) for s in sets for r in self.recordings]
        def run(j):
            s,r=j
            try: x=replay(r,self.model,parameters=s); return {c:x.columns[c] for c in r.measured}
            except Exception as e:
                print("FAIL",e); return {c:np.full(r.time.size,np.nan) for c in r.measured}
        with ThreadPoolExecutor(2) as ex: out=list(ex.map(run,jobs))
        n=len(self.recordings)
        return [out[k*n:(k+1)*n] for k in range(len(sets))]
