"""An agent with a body: it sees a table and carries out instructions in the simulator."""
