"""What people see: the command line, the diagnosis report, notebook display."""
