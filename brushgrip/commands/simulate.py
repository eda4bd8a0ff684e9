"""`brushgrip simulate`."""

from brushgrip.commands.options import (
    EffectModules,
    ModelFile,
    OneGround,
    OutFile,
    RecordingNames,
    RigFile,
)


def simulate(
    recordings: RecordingNames,
    out: OutFile,
    rig: RigFile = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    ground: OneGround = None,
) -> None:
    """Simulate the aligning torque for the angle and the load of recordings: t,M_z.

    No M_z is needed. mu comes from the model file where it knows the recording, else from the rig.
    Several recordings go to OUT_<recording>.csv.
    """
    from brushgrip.tasks import simulate as task

    task.simulate(
        recordings=recordings,
        out=out,
        rig=rig,
        model=model,
        effects=effects,
        ground=ground,
    )
