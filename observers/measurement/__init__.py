"""What is measured: measurement models, their motion and derivatives, and the error of a torque."""
