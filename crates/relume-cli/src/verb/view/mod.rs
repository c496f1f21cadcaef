//! `relume view`: textures under moving light in the browser, from a server that this machine alone reaches.

mod blocks;
mod notes;
mod server;
mod site;

use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::report::{Report, write_stderr};
use crate::viewer::{
    self, Delivery, PageData, PageSceneArgs, PlaneArgs, Preparation, Prepared, TextureSource,
};
use crate::{evaluated, paths};
use site::ViewerSite;

/// Arguments of `relume view`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume view wool.ptm --open\n  relume view small.ptm large.ptm\n\
                        The page is at the printed address until Ctrl-C ends the program.")]
pub struct Args {
    /// Textures: .ptm, .exr fields, pictures, tiles, .rlm models; several, 16 at most, are compared side by side
    #[arg(required = true, num_args = 1.., value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Port of the server [default: any that is free]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    planes: PlaneArgs,
    #[command(flatten)]
    scene: PageSceneArgs,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// Reads the textures, prints the address of the page, and serves it until a signal ends the program.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let sources = viewer::sources(&args.files, &args.planes)?;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, args.port.unwrap_or(0)));
    let listener = listener.map_err(|e| match args.port {
        Some(port) => Error::io(format!("cannot listen on port {port}: name another, or none"), &e),
        None => Error::io("cannot listen on a port of this machine", &e),
    })?;
    let port = listener.local_addr().map_err(|e| Error::io("the server has no address", &e))?.port();
    let site = site_of(args, sources, port, context)?;
    let url = site.url();
    let text = format!("{url}\nThe page is there until Ctrl-C ends this program.");
    let report = Report::new(text, json!({ "url": url, "port": port }));
    report.with_warnings(context.job.remarks()).print("view", context)?;
    if args.open && !open(&url) {
        write_stderr("relume: no browser could be started: open the address by hand");
    }
    server::serve(&listener, &site, &context.job)?;
    Ok(Report::new("", json!({})))
}

/// The page and the files of all textures. A file that cannot be shown is said on standard error and on the page.
fn site_of(args: &Args, sources: Vec<TextureSource>, port: u16, context: &Context) -> Result<ViewerSite> {
    let mut site = ViewerSite::new(port, context.job.clone())?;
    let scene = args.scene.read(&context.job)?;
    let environment = scene.environment.as_ref();
    let delivery = Delivery::Served;
    let preparation = Preparation { planes: &args.planes, evaluated: &args.evaluated, environment, delivery };
    let mut failure = None;
    let mut entries: Vec<Value> = Vec::new();
    let mut shown = None;
    for (i, source) in sources.into_iter().enumerate() {
        let path = source.path;
        match preparation.prepared(source, &context.job) {
            Ok(texture) => {
                shown.get_or_insert_with(|| texture.title.clone());
                let notes = add_notes(&mut site, i, path);
                entries.push(texture.entry(json!({ "folder": folder(i), "notes": notes })));
                add(&mut site, i, texture);
            }
            Err(error) => {
                context.job.proceed()?;
                if args.files.len() > 1 {
                    write_stderr(&format!("relume: {}", paths::on_one_line(&error.to_string())));
                }
                entries.push(json!({ "title": paths::text(path), "error": error.to_string() }));
                failure = Some(error);
            }
        }
    }
    let Some(title) = shown else {
        return Err(failure.expect("there is a file"));
    };
    let mesh = scene.mesh.map(|(title, bytes)| {
        site.add(viewer::MESH_NAME, "application/octet-stream", bytes);
        json!({ "title": title, "file": viewer::MESH_NAME })
    });
    let data = PageData { title, textures: entries.into(), mesh: mesh.into(), url: None };
    site.add("", "text/html; charset=utf-8", viewer::folder_page(&data).into_bytes());
    site.add(viewer::SCRIPT_NAME, "text/javascript; charset=utf-8", viewer::SCRIPT.as_bytes().to_vec());
    site.add(viewer::STYLE_NAME, "text/css; charset=utf-8", viewer::STYLE.as_bytes().to_vec());
    Ok(site)
}

/// Adds the annotations of texture `i`; gives the name under which the page reads and writes them. There is none for standard
/// input.
fn add_notes(site: &mut ViewerSite, i: usize, path: &Path) -> Option<String> {
    Some(site.add_notes(format!("annotations/{i}.json"), viewer::annotation_place(path)?))
}

/// The folder in which the page finds the files of texture `i`.
fn folder(i: usize) -> String {
    format!("textures/{i}/")
}

/// Adds the files of texture `i`.
fn add(site: &mut ViewerSite, i: usize, texture: Prepared) {
    let folder = folder(i);
    for (name, bytes) in texture.files {
        site.add(&format!("{folder}{name}"), "application/octet-stream", bytes);
    }
    if let Some(plane) = texture.plane {
        site.add_plane(&folder, plane);
    }
    if !site.has(viewer::THUMBNAIL_NAME) {
        site.add(viewer::THUMBNAIL_NAME, "image/jpeg", texture.thumbnail);
    }
}

/// Starts the browser; false where there is none.
fn open(url: &str) -> bool {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("explorer", &[])
    } else {
        ("xdg-open", &[])
    };
    let quiet =
        Command::new(program).args(before).arg(url).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    quiet.is_ok()
}
