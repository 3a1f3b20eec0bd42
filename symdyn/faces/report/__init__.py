"""The diagnosis report: one HTML file that needs no network and no script."""

from symdyn.faces.report.page import render_report, write_report

__all__ = ["render_report", "write_report"]
