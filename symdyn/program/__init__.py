"""The expression program: SSA form, passes, differentiation, cost table and reference evaluator."""
